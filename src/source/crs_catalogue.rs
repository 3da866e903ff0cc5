//! Looks up the units and the ellipsoid of an EPSG code. The catalogue contains Well-Known Text; only a few numbers of
//! it are needed here, and they are found without parsing the rest.

/// The kind of CRS that a code denotes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Projected,
    Geographic,
    Geocentric,
}

/// The needed parts of a catalogue entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Definition {
    pub kind: Kind,
    /// Metres per unit; radians per unit for a geographic CRS.
    pub unit: f64,
    /// Semi-major axis in metres and inverse flattening (0 for a sphere), if the CRS has an ellipsoid.
    pub ellipsoid: Option<[f64; 2]>,
}

/// Looks a code up; returns `None` if the catalogue does not contain it.
pub(super) fn look_up(epsg: u16) -> Option<Definition> {
    definition_from_wkt(text(epsg)?)
}

/// Returns the text of a code: the first version of Well-Known Text, except for a few codes.
pub(super) fn text(epsg: u16) -> Option<&'static str> {
    crs_definitions::from_code(epsg).map(|definition| definition.wkt)
}

/// The beginnings of a CRS in both versions of Well-Known Text, and the keyword of its unit. Version 1 uses `UNIT` for
/// both kinds; version 2 uses longer keywords that end in it.
const BEGINNINGS: [(&str, Kind, &str); 4] = [
    ("PROJCS[", Kind::Projected, ",UNIT[\""),
    ("GEOGCS[", Kind::Geographic, ",UNIT[\""),
    ("GEOGCRS[", Kind::Geographic, ",ANGLEUNIT[\""),
    ("GEOCCS[", Kind::Geocentric, ",UNIT[\""),
];

fn definition_from_wkt(wkt: &str) -> Option<Definition> {
    // Wrappers around a horizontal CRS (an accompanying vertical CRS, a datum shift) do not affect horizontal
    // positions.
    let wkt = match wkt.strip_prefix("COMPD_CS[") {
        Some(compound) => {
            let begin = compound.find("PROJCS[").or_else(|| compound.find("GEOGCS["))?;
            compound.get(begin..compound.find(",VERT_CS[").unwrap_or(compound.len()))?
        }
        None => wkt,
    };
    let wkt = wkt
        .strip_prefix("BOUNDCRS[SOURCECRS[")
        .map_or(wkt, |bound| bound.find(",TARGETCRS[").and_then(|end| bound.get(..end)).unwrap_or(bound));
    let (_, kind, unit_keyword) = BEGINNINGS.into_iter().find(|(beginning, ..)| wkt.starts_with(beginning))?;
    // The last unit belongs to the outermost CRS: a projected one contains the geographic one with its degrees.
    let unit = numbers_after(wkt.get(wkt.rfind(unit_keyword)?..)?).next()?;
    let ellipsoid = wkt.find("SPHEROID[\"").or_else(|| wkt.find("ELLIPSOID[\"")).and_then(|at| {
        let mut numbers = numbers_after(&wkt[at..]);
        Some([numbers.next()?, numbers.next()?])
    });
    Some(Definition { kind, unit, ellipsoid })
}

/// Returns the numbers that follow the quoted name in `KEYWORD["name",1,2,…`.
fn numbers_after(text: &str) -> impl Iterator<Item = f64> + '_ {
    let after_name = text.splitn(3, '"').nth(2).unwrap_or("");
    after_name.split([',', ']']).skip(1).map_while(|number| number.parse().ok())
}

/// Returns metres per linear unit for the EPSG code of the unit.
pub(super) fn metres_per_linear_unit(code: u16) -> Option<f64> {
    Some(match code {
        9001 => 1.0,
        9002 => 0.3048,
        9003 => 1200.0 / 3937.0,
        9004 => 0.304_797_265,
        9005 => 0.304_797_265_4,
        9014 => 1.8288,
        9030 => 1852.0,
        9031 => 1.000_013_596_5,
        9033 => 20.116_840_233_680_5,
        9035 => 5280.0 * 1200.0 / 3937.0,
        9036 => 1000.0,
        9037 => 0.914_391_795,
        9038 => 20.116_619_49,
        9040 => 0.914_398_414_616_028_7,
        9041 => 0.304_799_471_538_676,
        9042 => 20.116_765_121_552_6,
        9062 => 0.914_398_530_744_440_8,
        9080 => 0.304_799_510_248_147,
        9081 => 0.304_799_41,
        9093 => 1609.344,
        9094 => 0.304_799_710_181_508_6,
        9095 => 0.304_800_749_8,
        9096 => 0.9144,
        9097 => 20.1168,
        9098 => 0.201_168,
        1025 => 0.001,
        1033 => 0.01,
        _ => return None,
    })
}

/// Returns metres per unit of a vertical CRS in feet, for the EPSG code of the CRS; `None` for others.
pub(super) fn metres_per_unit_of_vertical_crs(epsg: u16) -> Option<f64> {
    let unit = match epsg {
        5702 | 6360 | 8052 => 9003,
        6130 | 6131 | 6132 | 8050 | 8228 => 9002,
        5754 => 9095,
        _ => return None,
    };
    metres_per_linear_unit(unit)
}

/// Returns radians per angular unit for the EPSG code of the unit.
pub(super) fn radians_per_angular_unit(code: u16) -> Option<f64> {
    let degree = std::f64::consts::PI / 180.0;
    Some(match code {
        9101 => 1.0,
        9102 | 9122 => degree,
        9103 => degree / 60.0,
        9104 => degree / 3600.0,
        9105 | 9106 => std::f64::consts::PI / 200.0,
        9109 => 1e-6,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_ellipsoids_are_found() {
        let wgs84 = Some([6_378_137.0, 298.257_223_563]);
        let utm = look_up(32610).unwrap();
        assert_eq!(utm, Definition { kind: Kind::Projected, unit: 1.0, ellipsoid: wgs84 });
        let feet = look_up(26730).unwrap();
        assert!((feet.unit - 1200.0 / 3937.0).abs() < 1e-15, "{feet:?}");
        let degrees = look_up(4326).unwrap();
        assert_eq!((degrees.kind, degrees.ellipsoid), (Kind::Geographic, wgs84));
        assert!((degrees.unit - std::f64::consts::PI / 180.0).abs() < 1e-15);
        let grads = look_up(4807).unwrap();
        assert!((grads.unit - std::f64::consts::PI / 200.0).abs() < 1e-15, "{grads:?}");
        assert_eq!(look_up(7415).unwrap().kind, Kind::Projected, "compound");
        assert_eq!(look_up(4978).unwrap().kind, Kind::Geocentric);
        assert_eq!(look_up(4979).unwrap(), degrees, "three-dimensional, second generation of the text");
        assert_eq!(look_up(3823).unwrap().kind, Kind::Geographic, "bound");
        assert_eq!(look_up(1), None);
    }
}
