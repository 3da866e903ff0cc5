//! Folders of height files, and folders of tiles.

use std::path::Path;

use hachure::internals::{Kind, kind_of, members};
use hachure::source::{self, Silent, SourceError};

use crate::dem::Dem;
use crate::write;

/// Writes level 3 with tiles (4, 2), (5, 2) and (5, 3) of 256 pixels; (4, 3) is left out.
fn tiles(folder: &Path) -> Dem {
    let mut dem = Dem::new(512, 512, 0);
    for (column, row) in [(0, 0), (1, 0), (1, 1)] {
        let heights = (0..256 * 256).map(|index| dem.at(column * 256 + index % 256, row * 256 + index / 256)).collect();
        let path = folder.join(format!("3/{}", 4 + column));
        std::fs::create_dir_all(&path).unwrap();
        let tile = Dem { width: 256, height: 256, heights };
        write::terrain_rgb(&path.join(format!("{}.png", 2 + row)), &tile, false);
    }
    for row in 256..512 {
        dem.heights[row * 512..][..256].fill(i16::MIN);
    }
    // A coarser level is ignored.
    std::fs::create_dir_all(folder.join("2/2")).unwrap();
    write::terrain_rgb(&folder.join("2/2/1.png"), &Dem::new(256, 256, 0), false);
    dem
}

#[test]
fn tiles_are_one_grid() {
    let folder = tempfile::tempdir().unwrap();
    let dem = tiles(folder.path());
    assert_eq!(kind_of(folder.path()), Kind::TileFolder);
    let pixel = 40_075_016.685_578_49 / 8.0 / 256.0;
    let place = [0.5 * pixel, pixel, 0.0, 20_037_508.342_789_244 - 512.5 * pixel, 0.0, -pixel];
    let grid = crate::compare::check(folder.path(), &dem, place);
    assert_eq!(grid.georeference.geokeys.epsg, Some(3857));
    let before = source::open_reader(folder.path()).unwrap().identity();
    std::fs::write(folder.path().join("3/4/2.png"), b"no picture").unwrap();
    let error = source::open(folder.path(), &Silent).unwrap_err().to_string();
    assert!(error.contains("2.png: is damaged") && !error.contains('\n'), "{error}");
    std::fs::remove_file(folder.path().join("3/4/2.png")).unwrap();
    assert_ne!(source::open_reader(folder.path()).unwrap().identity(), before);
    // A tile number that level 3 does not have.
    std::fs::copy(folder.path().join("3/5/2.png"), folder.path().join("3/5/8.png")).unwrap();
    let error = source::open(folder.path(), &Silent).unwrap_err().to_string();
    assert!(error.contains("8×8 tiles"), "{error}");
}

#[test]
fn members_are_the_height_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let none = members(folder.path()).unwrap_err();
    assert!(matches!(none, SourceError::NoMembers { .. }) && none.to_string().contains("holds no height files"));
    assert!(matches!(source::open(folder.path(), &Silent), Err(SourceError::NotAFile { .. })));

    let dem = Dem::new(20, 20, 0).above_sea();
    std::fs::create_dir(at("more")).unwrap();
    write::ehdr(&at("a.bil"), &dem, "I");
    write::grid_float(&at("b.flt"), &dem);
    write::ascii(&at("more/c.asc"), &dem, false);
    write::png16(&at("d.png"), &dem);
    write::raw(&at("e.r16"), &dem, false);
    std::fs::write(at("e.r16.toml"), "spacing_m = 3").unwrap();
    write::hgt_zip(&at("textures.zip"), "grass.jpg", &dem);
    write::hgt(&at("N46E008.hgt"), &Dem::new(1201, 1201, 0));
    std::fs::write(at("readme.txt"), "notes\n").unwrap();
    std::fs::write(at("path.csv"), "t,x,y,z,yaw,pitch,fov\n0,1,2,3,4,5,6\n1,1,3,3,4,5,6\n2,2,2,3,4,5,6\n").unwrap();
    std::fs::write(at("a.bil.aux.xml"), "<PAMDataset/>").unwrap();
    std::fs::write(at("empty.tif"), "").unwrap();
    write::png(&at("photo.png"), [8, 8], png::ColorType::Grayscale, png::BitDepth::Eight, &[7; 64]);
    // A damaged file is a member: ignoring it would leave a hole without a message.
    std::fs::write(at("broken.tif"), b"II*\0garbage").unwrap();
    // A mask and overviews belong to the file next to them.
    std::fs::write(at("broken.tif.msk"), b"II*\0mask").unwrap();
    std::fs::write(at("broken.tif.ovr"), b"II*\0overviews").unwrap();
    std::fs::create_dir(at("tiles")).unwrap();
    tiles(&at("tiles"));

    assert_eq!(kind_of(folder.path()), Kind::Folder);
    assert_eq!(kind_of(&at("a.bil")), Kind::File);
    let names: Vec<String> = members(folder.path())
        .unwrap()
        .iter()
        .map(|path| path.strip_prefix(folder.path()).unwrap().to_string_lossy().replace('\\', "/"))
        .collect();
    assert_eq!(names, ["N46E008.hgt", "a.bil", "b.flt", "broken.tif", "d.png", "e.r16", "more/c.asc", "tiles"]);
}
