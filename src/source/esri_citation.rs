//! Interprets the text with which ESRI's software describes a CRS in a citation, where a GeoTIFF should have codes.
//!
//! ArcGIS writes Well-Known Text after `ESRI PE String = `, or `PCS Name = `, and a model type of 32767
//! ("user-defined"), which the standard does not define. The other keys often describe the underlying geographic CRS,
//! so that a file in metres would be mistaken for one in degrees.

use super::geokeys::{self as key, GeoKey, GeoKeys, USER_DEFINED};
use super::wkt;

const WELL_KNOWN_TEXT: &str = "ESRI PE String = ";
const PROJECTED_NAME: &str = "PCS Name = ";

/// The keys of heights, which are copied from the file, as is the raster type.
const KEPT: std::ops::RangeInclusive<u16> = key::VERTICAL_CRS..=key::VERTICAL_UNITS;

/// Replaces the keys by those that a citation describes. Keys that give their CRS by a code stay unchanged.
pub(super) fn understood(keys: GeoKeys) -> GeoKeys {
    let is_own_model = !matches!(keys.model_type, Some(1..=3));
    let has_code = match keys.model_type {
        Some(2) => keys.short(key::GEOGRAPHIC_CRS),
        _ => keys.short(key::PROJECTED_CRS),
    };
    if has_code.is_some_and(|code| code != 0 && code != USER_DEFINED) {
        return keys;
    }
    let citations = [key::PROJECTED_CITATION, key::CITATION, key::GEOGRAPHIC_CITATION];
    let after =
        |mark: &str| citations.into_iter().find_map(|id| Some(keys.ascii(id)?.split_once(mark)?.1)).map(str::to_owned);
    let stated = after(WELL_KNOWN_TEXT).and_then(|text| wkt::keys(&text));
    if let Some(stated) = stated {
        return with(&keys, stated.keys);
    }
    match after(PROJECTED_NAME).filter(|_| is_own_model) {
        Some(name) => {
            let name = name.split([';', '|', '\n']).next().unwrap_or_default().trim();
            let base = keys.short(key::GEOGRAPHIC_CRS).unwrap_or(USER_DEFINED);
            let code = wkt::utm_code(name, base).unwrap_or(USER_DEFINED);
            let mut stated = vec![
                GeoKey::short(key::MODEL_TYPE, 1),
                GeoKey::short(key::PROJECTED_CRS, code),
                GeoKey::ascii(key::CITATION, name),
            ];
            let stays = |id: u16| (key::GEOGRAPHIC_CRS..key::VERTICAL_CRS).contains(&id) && id != key::PROJECTED_CRS;
            stated.extend(keys.keys.iter().filter(|key| stays(key.id)).cloned());
            with(&keys, stated)
        }
        None => keys,
    }
}

fn with(old: &GeoKeys, mut stated: Vec<GeoKey>) -> GeoKeys {
    let kept = old.keys.iter().filter(|it| it.id == key::RASTER_TYPE || KEPT.contains(&it.id));
    stated.extend(kept.cloned());
    GeoKeys::from_keys(stated)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(citation: &str) -> GeoKeys {
        GeoKeys::from_keys(vec![
            GeoKey::short(key::MODEL_TYPE, USER_DEFINED),
            GeoKey::short(key::RASTER_TYPE, 2),
            GeoKey::short(key::GEOGRAPHIC_CRS, 4326),
            GeoKey::short(key::VERTICAL_UNITS, 9002),
            GeoKey::ascii(key::PROJECTED_CITATION, citation),
        ])
    }

    #[test]
    fn well_known_text_stands_for_the_keys() {
        let text = r#"ESRI PE String = PROJCS["WGS_1984_UTM_Zone_10N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",
            SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],
            PROJECTION["Transverse_Mercator"],UNIT["Meter",1.0]]"#;
        let keys = understood(file(text));
        assert_eq!((keys.model_type, keys.epsg, keys.raster_type), (Some(1), Some(32610), Some(2)));
        assert_eq!(keys.short(key::VERTICAL_UNITS), Some(9002), "heights stay in feet");
        let named = understood(file("PCS Name = WGS_1984_UTM_Zone_33S;x"));
        assert_eq!((named.model_type, named.epsg), (Some(1), Some(32733)));
        let unknown = understood(file("PCS Name = Somewhere"));
        assert_eq!((unknown.model_type, unknown.epsg), (Some(1), None));
    }

    #[test]
    fn codes_and_other_citations_stay() {
        let plain = file("nothing of the kind");
        assert_eq!(understood(plain.clone()), plain);
        let mut coded = file("ESRI PE String = PROJCS[\"WGS_1984_UTM_Zone_10N\"]");
        coded.keys.push(GeoKey::short(key::PROJECTED_CRS, 2056));
        let coded = GeoKeys::from_keys(coded.keys);
        assert_eq!(understood(coded.clone()), coded);
    }
}
