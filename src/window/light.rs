//! The controls of light in the panel: the light rose, the sun by date and time, haze, focus.

use egui::{Color32, Pos2, RichText, Sense, Ui, Vec2};

use super::panel::{WARNING, labelled, steady_slider};
use super::settings::Settings;
use crate::scene::sun_time::{LatLon, Moment};
use crate::scene::{Sun, SunTime};
use crate::source::EarthPlace;

/// Side of the light rose, in points.
const ROSE: f32 = 104.0;
/// The number of days in each month of a common year.
const MONTHS: [u32; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

/// The state of the controls that is not a setting of the picture.
#[derive(Debug)]
pub(super) struct LightPanel {
    /// Location of the heights.
    earth: Option<EarthPlace>,
    /// Date and time as they are typed.
    moment: String,
    /// The reason why no sun follows from the date, if none does.
    error: Option<String>,
}

/// The user's requests in the controls of light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct LightRequests {
    /// Whether the next click on the picture places the focus.
    pub place_focus: bool,
}

impl LightPanel {
    /// Creates the controls for heights at a location; their first date is a summer's noon.
    pub(super) fn new(earth: Option<EarthPlace>) -> Self {
        let zone = earth.map_or(0, |earth| (earth.longitude_deg / 15.0).round() as i32);
        let moment = format!("2026-06-21T12:00{}{:02}:00", if zone < 0 { '-' } else { '+' }, zone.abs());
        Self { earth, moment, error: None }
    }

    /// Adds the controls. `yaw_deg` is the direction of the camera, clockwise from north.
    pub(super) fn show(&mut self, ui: &mut Ui, settings: &mut Settings, yaw_deg: f64) -> LightRequests {
        ui.vertical_centered(|ui| rose(ui, &mut settings.sun, yaw_deg));
        let slider = steady_slider(&mut settings.sun.azimuth_deg, 0.0..=360.0).suffix("°").max_decimals(0);
        labelled(ui, "Sun azimuth", "Azimuth, clockwise from north (--sun)", slider);
        let slider = steady_slider(&mut settings.sun.elevation_deg, -10.0..=90.0).suffix("°").max_decimals(0);
        labelled(ui, "Sun elevation", "Elevation above the horizon (--sun)", slider);
        self.date(ui, &mut settings.sun);
        haze(ui, settings);
        focus(ui, settings)
    }

    /// Adds the controls of date and time.
    fn date(&mut self, ui: &mut Ui, sun: &mut Sun) {
        let before = self.moment.clone();
        let hint = "Date and local time with the UTC offset, like 2026-06-21T09:30+02:00 (--date)";
        let field = egui::TextEdit::singleline(&mut self.moment).desired_width(150.0);
        ui.horizontal(|ui| {
            ui.label(RichText::new("Date").weak()).on_hover_text(hint);
            let field = ui.add(field).on_hover_text(hint);
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("Date and time of the sun"));
        });
        if let Some([day, minute]) = day_and_minute(&self.moment) {
            let [mut new_day, mut new_minute] = [day, minute];
            labelled(ui, "Day of the year", "Day of the year", steady_slider(&mut new_day, 1..=365));
            let hours = |minute: f64, _| format!("{:02}:{:02}", minute as u32 / 60, minute as u32 % 60);
            let slider = steady_slider(&mut new_minute, 0..=1439).custom_formatter(hours);
            labelled(ui, "Time of day", "Local time", slider);
            if [new_day, new_minute] != [day, minute] {
                self.moment = with_day_and_minute(&self.moment, new_day, new_minute);
            }
        }
        if self.moment != before {
            match self.sun_at(&self.moment) {
                Ok(found) => (*sun, self.error) = (found, None),
                Err(error) => self.error = Some(error),
            }
        }
        if let Some(error) = &self.error {
            ui.add(egui::Label::new(RichText::new(error).color(WARNING)).wrap());
        }
    }

    /// Returns the sun at a date and time over the heights.
    fn sun_at(&self, moment: &str) -> Result<Sun, String> {
        let moment: Moment = moment.parse()?;
        let place = None::<LatLon>;
        SunTime { moment, place }.sun(self.earth).map_err(|error| error.to_string())
    }
}

/// Returns the day of the year and the minute of the day of a date; `None` if it is not complete.
fn day_and_minute(moment: &str) -> Option<[u32; 2]> {
    let _: Moment = moment.parse().ok()?;
    let text = moment.trim();
    let number = |range: std::ops::Range<usize>| text.get(range)?.parse::<u32>().ok();
    let [month, day, hour, minute] = [number(5..7)?, number(8..10)?, number(11..13)?, number(14..16)?];
    let before: u32 = MONTHS.iter().take(month.saturating_sub(1) as usize).sum();
    Some([(before + day).min(365), hour * 60 + minute])
}

/// Returns a complete date with another day of its year and another minute of its day.
fn with_day_and_minute(moment: &str, day: u32, minute: u32) -> String {
    let text = moment.trim();
    let (mut month, mut left) = (0, day.clamp(1, 365));
    while left > MONTHS[month] {
        left -= MONTHS[month];
        month += 1;
    }
    let (year, rest) = (text.get(..4).unwrap_or_default(), text.get(16..).unwrap_or_default());
    format!("{year}-{:02}-{left:02}T{:02}:{:02}{rest}", month + 1, minute / 60, minute % 60)
}

/// Adds the slider of haze.
fn haze(ui: &mut Ui, settings: &mut Settings) {
    let mut haze_km = settings.haze_m / 1000.0;
    let slider = steady_slider(&mut haze_km, 0.1..=10_000.0).logarithmic(true).suffix(" km").max_decimals(1);
    labelled(ui, "Haze", "Distance at which 63 % of the contrast is lost (--haze)", slider);
    if (haze_km * 1000.0 - settings.haze_m).abs() > 1e-6 * settings.haze_m {
        settings.haze_m = haze_km * 1000.0;
    }
}

/// Adds the controls of the focus.
fn focus(ui: &mut Ui, settings: &mut Settings) -> LightRequests {
    let mut requests = LightRequests::default();
    ui.horizontal(|ui| {
        ui.label(RichText::new("Focus").weak()).on_hover_text("An area of full contrast (--focus)");
        let hint = "The next click on the picture places the area of full contrast";
        requests.place_focus = ui.button("Place by click").on_hover_text(hint).clicked();
        let has_focus = settings.focus.is_some();
        let remove = ui.add_enabled(has_focus, egui::Button::new("Remove"));
        if remove.on_hover_text("Full contrast everywhere, as far as the style has no focus").clicked() {
            settings.focus = None;
        }
    });
    if let Some(focus) = &mut settings.focus {
        let slider =
            steady_slider(&mut focus.radius_m, 10.0..=100_000.0).logarithmic(true).suffix(" m").max_decimals(0);
        labelled(ui, "Focus radius", "Radius of full contrast", slider);
        let slider = steady_slider(&mut focus.strength, 0.0..=1.0).max_decimals(2);
        labelled(ui, "Focus strength", "Share of the contrast that is lost far from the focus", slider);
    }
    requests
}

/// Adds the light rose: a disc whose handle is the sun, seen from above. North is up; the centre is the zenith, and the
/// rim is the horizon.
fn rose(ui: &mut Ui, sun: &mut Sun, yaw_deg: f64) {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(ROSE), Sense::click_and_drag());
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label("Sun: direction and height"));
    let (centre, radius) = (rect.center(), 0.5 * ROSE - 10.0);
    if let Some(at) = response.interact_pointer_pos() {
        *sun = sun_at(at, centre, radius);
    }
    let painter = ui.painter_at(rect);
    painter.circle(centre, radius, Color32::from_white_alpha(14), (1.0, Color32::from_white_alpha(110)));
    for part in [1.0 / 3.0, 2.0 / 3.0] {
        painter.circle_stroke(centre, radius * part, (0.5, Color32::from_white_alpha(50)));
    }
    let north = centre - Vec2::new(0.0, radius);
    painter.text(north, egui::Align2::CENTER_BOTTOM, "N", egui::FontId::proportional(9.0), Color32::from_gray(190));
    // The direction of the camera.
    let ahead = Vec2::angled((yaw_deg.to_radians() - std::f64::consts::FRAC_PI_2) as f32);
    painter.line_segment([centre + ahead * (radius * 0.8), centre + ahead * radius], (2.0, Color32::from_gray(150)));
    let handle = place_of(*sun, centre, radius);
    painter.line_segment([centre, handle], (1.0, Color32::from_rgb(250, 210, 90)));
    painter.circle_filled(handle, 5.0, Color32::from_rgb(250, 210, 90));
    response.on_hover_text(
        "Drag the sun: its direction with north up, and its height from the rim (horizon) to the middle",
    );
}

/// Returns the sun at a point of the light rose.
fn sun_at(at: Pos2, centre: Pos2, radius: f32) -> Sun {
    let way = (at - centre) / radius;
    let azimuth_deg = f64::from(way.x).atan2(f64::from(-way.y)).to_degrees().rem_euclid(360.0);
    let elevation_deg = 90.0 * (1.0 - f64::from(way.length()).min(1.0));
    // Whole tenths of a degree, so that an imprint is short.
    let rounded = |angle_deg: f64| (angle_deg * 10.0).round() / 10.0;
    Sun { azimuth_deg: rounded(azimuth_deg), elevation_deg: rounded(elevation_deg) }
}

/// Returns the point of the light rose at which the sun is; a sun below the horizon is on the rim.
fn place_of(sun: Sun, centre: Pos2, radius: f32) -> Pos2 {
    let azimuth_rad = (sun.azimuth_deg.to_radians() - std::f64::consts::FRAC_PI_2) as f32;
    let part = (1.0 - sun.elevation_deg.max(0.0) / 90.0) as f32;
    centre + Vec2::angled(azimuth_rad) * (radius * part)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    use super::*;

    struct Bench {
        panel: LightPanel,
        settings: Settings,
        requests: LightRequests,
    }

    fn harness<'a>(earth: Option<EarthPlace>) -> Harness<'a, Bench> {
        let bench = Bench {
            panel: LightPanel::new(earth),
            settings: crate::window::settings::tests::settings(),
            requests: LightRequests::default(),
        };
        let harness = Harness::builder().with_size(egui::vec2(300.0, 500.0));
        let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
            |ui, bench: &mut Bench| {
                let requests = bench.panel.show(ui, &mut bench.settings, 0.0);
                bench.requests.place_focus |= requests.place_focus;
            },
            bench,
        );
        harness.run();
        harness
    }

    #[test]
    fn the_rose_is_dragged() {
        let mut harness = harness(None);
        let rect = harness.get_by_label("Sun: direction and height").rect();
        let (centre, radius) = (rect.center(), 0.5 * ROSE - 10.0);
        harness.drag_at(centre + Vec2::new(0.0, 0.5 * radius));
        harness.step();
        let south = harness.state().settings.sun;
        assert!((south.azimuth_deg - 180.0).abs() < 1.0 && (south.elevation_deg - 45.0).abs() < 2.0, "{south:?}");
        harness.hover_at(centre + Vec2::new(2.0 * radius, 0.0));
        harness.step();
        let east = harness.state().settings.sun;
        assert!((east.azimuth_deg - 90.0).abs() < 1.0 && east.elevation_deg == 0.0, "beyond the rim: {east:?}");
        harness.drop_at(centre + Vec2::new(2.0 * radius, 0.0));
        harness.run();
        // The handle is where the sun is.
        for sun in [south, east, Sun { azimuth_deg: 300.5, elevation_deg: 12.3 }] {
            let found = sun_at(place_of(sun, centre, radius), centre, radius);
            assert!((found.azimuth_deg - sun.azimuth_deg).abs() < 0.2, "{sun:?} {found:?}");
            assert!((found.elevation_deg - sun.elevation_deg).abs() < 0.2, "{sun:?} {found:?}");
            // Planted error: azimuths counted from the east.
            let turned = Sun { azimuth_deg: sun.azimuth_deg + 90.0, ..sun };
            assert!(place_of(turned, centre, radius).distance(place_of(sun, centre, radius)) > 10.0);
        }
    }

    #[test]
    fn a_date_places_the_sun() {
        let alps = EarthPlace { latitude_deg: 46.5, longitude_deg: 8.0, grid_north_deg: 0.0 };
        let panel = LightPanel::new(Some(alps));
        assert_eq!(panel.moment, "2026-06-21T12:00+01:00");
        let noon = panel.sun_at(&panel.moment).unwrap();
        assert!((60.0..68.0).contains(&noon.elevation_deg) && (150.0..200.0).contains(&noon.azimuth_deg), "{noon:?}");
        assert_eq!(day_and_minute("2026-03-01T09:30+02:00"), Some([60, 570]));
        assert_eq!(day_and_minute("2026-03-0"), None);
        for (day, text) in [(1, "2026-01-01"), (59, "2026-02-28"), (60, "2026-03-01"), (365, "2026-12-31")] {
            let moved = with_day_and_minute("2026-06-21T12:00+01:00", day, 605);
            assert_eq!(moved, format!("{text}T10:05+01:00"));
            assert_eq!(day_and_minute(&moved), Some([day, 605]));
        }
        // At night and without a place, the sun stays, and a line says why.
        assert!(panel.sun_at("2026-06-21T01:00+01:00").unwrap_err().contains("below the horizon"));
        let mut harness = harness(None);
        let before = harness.state().settings.sun;
        harness.get_by_label("Date and time of the sun").click();
        harness.run();
        harness.key_press(egui::Key::End);
        harness.key_press(egui::Key::Backspace);
        harness.run();
        assert_eq!(harness.state().settings.sun, before);
        assert!(harness.state().panel.error.is_some());
        harness.get_by_label("Date and time of the sun").type_text("0");
        harness.run();
        assert!(harness.state().panel.error.as_ref().unwrap().contains("place"), "{:?}", harness.state().panel.error);
        assert_eq!(harness.state().settings.sun, before);
    }

    #[test]
    fn the_focus_is_placed_by_a_click() {
        let mut harness = harness(None);
        assert!(harness.query_by_label("Focus radius").is_none());
        harness.get_by_label("Place by click").click();
        harness.run();
        assert!(harness.state().requests.place_focus);
    }
}
