//! Tests of GeoPackages.

use rusqlite::Connection;

use super::super::{Reason, Skipped};
use super::{Folder, differences, read_all, samples, writers};

#[test]
fn a_layer_is_chosen_by_name() {
    let folder = Folder::new();
    let path = folder.path("several ?#%.gpkg");
    let features = samples(false);
    let connection = writers::empty_geopackage(&path);
    writers::add_table(&connection, "huts \"of\" 1", 100_000, &features[..2]);
    writers::add_table(&connection, "tracks", 4326, &features[2..]);
    drop(connection);
    let error = read_all(&path, None).unwrap_err().to_string();
    assert!(error.ends_with(": has 2 layers; choose one with --name-layer: huts \"of\" 1, tracks"), "{error}");
    let error = read_all(&path, Some("trails")).unwrap_err().to_string();
    assert!(error.ends_with(": has no layer \"trails\"; its layers are huts \"of\" 1, tracks"), "{error}");
    let (found, summary) = read_all(&path, Some("huts \"of\" 1")).unwrap();
    assert_eq!(differences(&features[..2], &found), Vec::<String>::new());
    assert_eq!(summary.crs.unwrap().text, "PROJCS[\"own\"]");
    let (found, summary) = read_all(&path, Some("tracks")).unwrap();
    assert_eq!(differences(&features[2..], &found), Vec::<String>::new());
    assert_eq!((summary.crs.unwrap().text.as_str(), summary.record_noun), ("EPSG:4326", "fid"));
    assert_eq!(folder.names(), ["several ?#%.gpkg"], "SQLite creates no files");
}

#[test]
fn databases_without_features_are_refused() {
    let folder = Folder::new();
    let path = folder.path("plain.gpkg");
    Connection::open(&path).unwrap().execute_batch("CREATE TABLE a (b)").unwrap();
    let error = read_all(&path, None).unwrap_err().to_string();
    assert!(error.contains("is a SQLite database, but not a GeoPackage with features"), "{error}");
    let path = folder.path("empty.gpkg");
    drop(writers::empty_geopackage(&path));
    let error = read_all(&path, None).unwrap_err().to_string();
    assert!(error.ends_with("is a GeoPackage without features"), "{error}");
}

#[test]
fn a_write_ahead_log_is_not_ignored() {
    let folder = Folder::new();
    let path = folder.path("a.gpkg");
    writers::geopackage(&path, &samples(false));
    let connection = Connection::open(&path).unwrap();
    connection.pragma_update(None, "journal_mode", "WAL").unwrap();
    connection.execute("DELETE FROM samples", []).unwrap();
    let error = read_all(&path, None).unwrap_err().to_string();
    assert!(error.contains("has changes that are only in the file with the ending -wal"), "{error}");
    connection.close().unwrap();
    assert_eq!(folder.names(), ["a.gpkg"]);
    assert_eq!(read_all(&path, None).unwrap().0.len(), 0);
}

#[test]
fn geometries_that_cannot_be_read_are_counted() {
    let folder = Folder::new();
    let path = folder.path("a.gpkg");
    writers::geopackage(&path, &samples(false));
    let connection = Connection::open(&path).unwrap();
    let curve = [&b"GP\0\x01\0\0\0\0\x01\x08\0\0\0\x03\0\0\0"[..], &[0; 48]].concat();
    let update = |fid: i32, blob: Option<&[u8]>| {
        connection.execute("UPDATE samples SET \"the geom\" = ?2 WHERE fid = ?1", (fid, blob)).unwrap();
    };
    update(2, Some(&curve));
    update(3, None);
    update(4, Some(b"\x01\x02"));
    update(5, Some(b"GP\0\x11\0\0\0\0"));
    connection.execute_batch("ALTER TABLE samples ADD picture BLOB; UPDATE samples SET picture = x'00ff'").unwrap();
    drop(connection);
    let (found, summary) = read_all(&path, None).unwrap();
    assert_eq!(found.iter().map(|it| it.record).collect::<Vec<_>>(), [1, 6]);
    let skipped = |reason, first| Skipped { reason, features: 1, parts: 0, first };
    let damaged = Reason::Damaged("it does not begin with GP");
    assert_eq!(
        summary.skipped,
        [
            skipped(Reason::Curve("CircularString"), 2),
            skipped(Reason::NoGeometry, 3),
            skipped(damaged, 4),
            skipped(Reason::Empty, 5)
        ]
    );
    assert_eq!(summary.attributes.last().map(|it| (&*it.name, it.binaries)), Some(("picture", 6)));
}

#[test]
fn views_are_read_but_do_not_run_forever() {
    let folder = Folder::new();
    let view = |name: &str, sql: &str| {
        let path = folder.path(name);
        writers::geopackage(&path, &samples(false));
        let connection = Connection::open(&path).unwrap();
        connection.execute_batch(&format!("CREATE VIEW v AS {sql}")).unwrap();
        let sql = "UPDATE gpkg_contents SET table_name = 'v'; UPDATE gpkg_geometry_columns SET table_name = 'v'";
        connection.execute_batch(sql).unwrap();
        read_all(&path, None)
    };
    let (found, summary) = view("a.gpkg", "SELECT \"the geom\", name FROM samples WHERE class IS NOT NULL").unwrap();
    assert_eq!((found.len(), summary.record_noun), (2, "row"));
    let endless =
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT NULL AS \"the geom\", i FROM n";
    let error = view("b.gpkg", endless).unwrap_err().to_string();
    assert!(error.ends_with("is damaged: a table has more rows than the file has bytes"), "{error}");
}
