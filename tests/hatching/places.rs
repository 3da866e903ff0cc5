//! Where the land has no slope, or all of them: plains, peaks, pits, saddles.

use glam::{DVec2, DVec3};

use crate::grain::{Land, WINDOW_PX, Window};
use crate::plane::{Inked, style};

/// Half of the land's side is 1600 m; what is special is in the middle.
const LANDS: [(&str, fn(f64, f64) -> f64); 6] = [
    ("plain", |_, _| 120.0),
    ("cone", |x, y| 500.0 - 0.5 * x.hypot(y)),
    ("dome", |x, y| 500.0 - (x * x + y * y) / 1500.0),
    ("pit", |x, y| 0.5 * x.hypot(y)),
    ("bowl", |x, y| (x * x + y * y) / 1500.0),
    ("saddle", |x, y| 500.0 + (x * x - y * y) / 1500.0),
];

const DIRECTIONS: [&str; 3] = ["slope", "contour", "fixed"];

fn layer(marks: &str, direction: &str) -> String {
    format!("[[hatching.layers]]\nmarks = \"{marks}\"\ndirection = \"{direction}\"\nlevel_deg = 20\n")
}

#[test]
fn tone_holds() {
    for (name, height_m) in LANDS {
        let Some(mut land) = Land::new(321, 10.0, height_m) else { return };
        for scale in ["blend", "add"] {
            for direction in DIRECTIONS {
                for marks in ["line", "hachure"] {
                    for camera in ["0,0,+900,15,-90,40", "0,-900,+600,0,-35,40"] {
                        let mut line = String::new();
                        for darkness in [0.3, 0.6] {
                            let style = style(scale, darkness, &layer(marks, direction));
                            let pose = land.world.pose(camera);
                            let mut moved = pose;
                            moved.position_m += DVec3::new(3.0, 2.0, 4.0);
                            let (shot, next) = (land.look(pose, &style), land.look(moved, &style));
                            let changes = shot.changes(&next);
                            let windows = shot.windows();
                            let near = |w: &Window| w.place_m.truncate().length() < 120.0;
                            let most = |is_near: bool| {
                                windows.iter().filter(|w| near(w) == is_near).map(|w| (w.ink - darkness).abs()).fold(0.0, f64::max)
                            };
                            let change = |is_near: bool| {
                                let all: Vec<f64> = shot.place_m.iter().zip(&changes).filter_map(|(p, c)| ((*p)?.truncate().length() < 120.0).then_some(()).is_some().eq(&is_near).then_some((*c)?)).collect();
                                all.iter().sum::<f64>() / all.len() as f64
                            };
                            line += &format!(" | {darkness}: ink {:.3} {:.3} change {:.3} {:.3}", most(true), most(false), change(true), change(false));
                            if scale == "blend" || darkness < 0.4 { crate::grain::keep(&shot, &format!("{name}_{scale}_{direction}_{marks}_{}", &camera[..2])); }
                        }
                        println!("{name} {scale} {direction} {marks} {}{line}", &camera[..3]);
                    }
                }
            }
        }
    }
}
