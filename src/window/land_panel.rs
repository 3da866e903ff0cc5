//! The controls of the land in the panel: exaggeration, the sea, the trees, and the seed of a land that is grown.

use egui::{Align, Checkbox, DragValue, Layout, RichText, Slider, Ui};

use super::panel::labelled;
use super::settings::Settings;
use crate::scene::{Forest, ranges};

/// The state of the controls that is not a setting of the picture.
#[derive(Debug)]
pub(super) struct LandPanel {
    /// Lowest and highest true height of the land, in metres.
    range_m: [f64; 2],
    /// The height to which the sea returns when it is switched on.
    last_sea_m: f64,
    /// The seed with which trees return when they are switched on.
    last_tree_seed: u32,
    /// The reason why the land cannot have another seed, if it cannot.
    refusal: Option<String>,
}

impl LandPanel {
    /// Creates the controls for land between two true heights, in metres, whose scene has a forest or none. `refusal`
    /// says why the land cannot have another seed.
    pub(super) fn new(range_m: [f64; 2], own_forest: Option<&Forest>, refusal: Option<String>) -> Self {
        let last_tree_seed = own_forest.map_or(Forest::DEFAULT_SEED, |forest| forest.seed);
        Self { range_m, last_sea_m: first_sea_m(range_m), last_tree_seed, refusal }
    }

    /// Adds the controls. `draws_water` says whether the drawn style has a layer of water.
    pub(super) fn show(&mut self, ui: &mut Ui, settings: &mut Settings, draws_water: bool) {
        let slider = Slider::new(&mut settings.exaggeration, 0.2..=10.0).logarithmic(true).suffix(" ×").max_decimals(2);
        let slider = slider.clamping(egui::SliderClamping::Never);
        labelled(ui, "Exaggeration", "Factor on all heights (--exaggeration); the land is read again", slider);
        if !ranges::EXAGGERATION.holds(settings.exaggeration) {
            settings.exaggeration = 1.0;
        }
        self.sea(ui, &mut settings.sea_level_m);
        self.trees(ui, &mut settings.tree_seed);
        if let Some(seed) = &mut settings.world_seed {
            ui.add_enabled_ui(self.refusal.is_none(), |ui| {
                let hint = "Each seed is another land, which is opened in the background (--seed)";
                let hint =
                    self.refusal.as_ref().map_or_else(|| hint.to_owned(), |cause| format!("No other seed: {cause}"));
                seed_row(ui, "World seed", &hint, seed);
            });
        }
        // The line is below all controls, so that none of them moves under the mouse when it appears or disappears.
        if settings.sea_level_m.is_some() && !draws_water {
            let text = "This style draws no water: it has no layer “water”.";
            ui.add(egui::Label::new(RichText::new(text).weak()).wrap());
        }
    }

    /// Adds the switch and the height of the sea. The height keeps its row without a sea: where frames are slow, a
    /// row that appears would move the ones below away from under the next click.
    fn sea(&mut self, ui: &mut Ui, sea_level_m: &mut Option<f64>) {
        let mut is_on = sea_level_m.is_some();
        let hint = "Whether low land is sea (--sea-level), in styles that draw water";
        labelled(ui, "Sea", hint, Checkbox::new(&mut is_on, ""));
        let mut level_m = sea_level_m.unwrap_or(self.last_sea_m);
        let [low_m, high_m] = self.range_m;
        ui.add_enabled_ui(is_on, |ui| {
            // A scene's sea may be far from the land, and so may a number that is typed.
            let slider = Slider::new(&mut level_m, low_m..=high_m).clamping(egui::SliderClamping::Never);
            let slider = slider.suffix(" m").max_decimals(1);
            labelled(ui, "Sea level", "Land at or below this true height is sea (--sea-level)", slider);
        });
        if is_on && ranges::SEA_LEVEL_M.holds(level_m) {
            self.last_sea_m = level_m;
        }
        *sea_level_m = is_on.then_some(self.last_sea_m);
    }

    /// Adds the switch and the seed of the trees.
    fn trees(&mut self, ui: &mut Ui, tree_seed: &mut Option<u32>) {
        let mut is_on = tree_seed.is_some();
        let hint = "The forest of the scene, or a mixed forest if it has none (--trees)";
        labelled(ui, "Trees", hint, Checkbox::new(&mut is_on, ""));
        let mut seed = tree_seed.unwrap_or(self.last_tree_seed);
        ui.add_enabled_ui(is_on, |ui| {
            seed_row(ui, "Tree seed", "Each seed is another forest by the same rules (--trees)", &mut seed);
        });
        if is_on {
            self.last_tree_seed = seed;
        }
        *tree_seed = is_on.then_some(seed);
    }
}

/// Returns the height of a sea that is switched on over land between two heights: that of the oceans, if the land
/// reaches down to it, or else a tenth of the way up, so that there is something to see.
fn first_sea_m([low_m, high_m]: [f64; 2]) -> f64 {
    let level_m = if low_m <= 0.0 && high_m >= 0.0 { 0.0 } else { (low_m + 0.1 * (high_m - low_m)).round() };
    if ranges::SEA_LEVEL_M.holds(level_m) { level_m } else { 0.0 }
}

/// Adds a row with a seed and a button that takes the next one.
fn seed_row(ui: &mut Ui, name: &str, hint: &str, seed: &mut u32) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(name).weak()).on_hover_text(hint);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let next = ui.button("Next").on_hover_text("Take the next seed").on_disabled_hover_text(hint);
            ui.ctx().accesskit_node_builder(next.id, |node| node.set_label(format!("{name}, next")));
            if next.clicked() {
                *seed = seed.wrapping_add(1);
            }
            // A number counts when it is complete.
            let field = DragValue::new(seed).speed(0.05).update_while_editing(false);
            let field = ui.add(field).on_hover_text(hint).on_disabled_hover_text(hint);
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(name));
        });
    });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use egui::accesskit::Role;
    use egui_kittest::kittest::{NodeT as _, Queryable as _};
    use egui_kittest::{Harness, Node};

    use super::*;

    struct Bench {
        panel: LandPanel,
        settings: Settings,
        draws_water: bool,
    }

    fn harness<'a>(settings: Settings) -> Harness<'a, Bench> {
        let own = settings.tree_seed.map(|seed| Forest { seed, ..Forest::default() });
        let bench = Bench { panel: LandPanel::new([400.0, 2400.0], own.as_ref(), None), settings, draws_water: true };
        let harness = Harness::builder().with_size(egui::vec2(264.0, 400.0));
        let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
            |ui, bench: &mut Bench| bench.panel.show(ui, &mut bench.settings, bench.draws_water),
            bench,
        );
        harness.run();
        harness
    }

    fn bare() -> Settings {
        crate::window::settings::tests::settings()
    }

    /// Returns the widget of a name; the text in front of it has the same.
    fn widget<'a>(harness: &'a Harness<'_, Bench>, name: &'a str) -> Option<Node<'a>> {
        harness.query_all_by_label(name).find(|node| node.accesskit_node().role() != Role::Label)
    }

    fn click(harness: &mut Harness<'_, Bench>, name: &str) {
        widget(harness, name).unwrap().click();
        harness.run();
    }

    /// Types a number into a field.
    fn type_into(harness: &mut Harness<'_, Bench>, name: &str, text: &str) {
        click(harness, name);
        harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
        harness.run();
        widget(harness, name).unwrap().type_text(text);
        harness.run();
        harness.key_press(egui::Key::Enter);
        harness.run();
    }

    #[test]
    fn the_sea_is_switched_and_flooded() {
        let mut harness = harness(bare());
        let is_disabled =
            |harness: &Harness<'_, Bench>, name: &str| widget(harness, name).unwrap().accesskit_node().is_disabled();
        let top = |harness: &Harness<'_, Bench>| widget(harness, "Trees").unwrap().rect().top();
        let before = top(&harness);
        assert!(is_disabled(&harness, "Sea level") && is_disabled(&harness, "Tree seed"));
        click(&mut harness, "Sea");
        assert_eq!(harness.state().settings.sea_level_m, Some(600.0), "a tenth of the way up");
        assert!(!is_disabled(&harness, "Sea level"));
        assert_eq!(top(&harness), before, "what is below stays under the next click");
        // The ends of the slider are the heights of the land.
        let rect = widget(&harness, "Sea level").unwrap().rect();
        harness.drag_at(rect.right_center() - egui::vec2(2.0, 0.0));
        harness.step();
        assert_eq!(harness.state().settings.sea_level_m, Some(2400.0), "while it is dragged");
        harness.drop_at(rect.right_center());
        harness.run();
        type_into(&mut harness, "Sea level, number", "-12.5");
        assert_eq!(harness.state().settings.sea_level_m, Some(-12.5), "a number may be beyond the slider");
        type_into(&mut harness, "Sea level, number", "9500");
        assert_eq!(harness.state().settings.sea_level_m, Some(-12.5), "but not beyond what a scene may have");
        // Switched off and on, the sea is at the same level as before.
        click(&mut harness, "Sea");
        assert_eq!(harness.state().settings.sea_level_m, None);
        assert!(is_disabled(&harness, "Sea level"));
        click(&mut harness, "Sea");
        assert_eq!(harness.state().settings.sea_level_m, Some(-12.5));
    }

    #[test]
    fn a_first_sea_shows_something() {
        assert_eq!(first_sea_m([0.0, 900.0]), 0.0);
        assert_eq!(first_sea_m([-20.0, 900.0]), 0.0);
        assert_eq!(first_sea_m([1000.0, 3000.0]), 1200.0);
        assert_eq!(first_sea_m([-900.0, -400.0]), -850.0);
        assert_eq!(first_sea_m([20_000.0, 30_000.0]), 0.0);
    }

    #[test]
    fn a_style_without_water_says_so() {
        let mut harness = harness(Settings { sea_level_m: Some(700.0), ..bare() });
        let says_so = |harness: &Harness<'_, Bench>| harness.query_by_label_contains("draws no water").is_some();
        assert!(!says_so(&harness));
        harness.state_mut().draws_water = false;
        harness.run();
        assert!(says_so(&harness));
        // The sea of the scene stays, for the next style.
        assert_eq!(harness.state().settings.sea_level_m, Some(700.0));
    }

    #[test]
    fn trees_are_switched_and_sown() {
        let mut harness = harness(bare());
        click(&mut harness, "Trees");
        assert_eq!(harness.state().settings.tree_seed, Some(1), "the seed of an empty table");
        click(&mut harness, "Tree seed, next");
        assert_eq!(harness.state().settings.tree_seed, Some(2));
        type_into(&mut harness, "Tree seed", "4294967295");
        assert_eq!(harness.state().settings.tree_seed, Some(u32::MAX));
        click(&mut harness, "Tree seed, next");
        assert_eq!(harness.state().settings.tree_seed, Some(0), "the seeds are a circle");
        type_into(&mut harness, "Tree seed", "17");
        click(&mut harness, "Trees");
        assert_eq!(harness.state().settings.tree_seed, None);
        assert!(widget(&harness, "Tree seed, next").unwrap().accesskit_node().is_disabled());
        click(&mut harness, "Tree seed, next");
        click(&mut harness, "Trees");
        assert_eq!(harness.state().settings.tree_seed, Some(17));
        // The forest of a scene has its seed.
        let mut of_scene = self::harness(Settings { tree_seed: Some(5), ..bare() });
        click(&mut of_scene, "Trees");
        click(&mut of_scene, "Trees");
        assert_eq!(of_scene.state().settings.tree_seed, Some(5));
    }

    #[test]
    fn the_seed_of_a_grown_land_is_changed() {
        let mut harness = harness(bare());
        assert!(widget(&harness, "World seed").is_none(), "land of files has no seed");
        harness.state_mut().settings.world_seed = Some(1);
        harness.run();
        click(&mut harness, "World seed, next");
        assert_eq!(harness.state().settings.world_seed, Some(2));
        type_into(&mut harness, "World seed", "77");
        assert_eq!(harness.state().settings.world_seed, Some(77));
        // Where models have their places, the number is shown and stays.
        harness.state_mut().panel.refusal = Some("its models are made for it".to_owned());
        harness.run();
        assert!(widget(&harness, "World seed, next").unwrap().accesskit_node().is_disabled());
        click(&mut harness, "World seed, next");
        assert_eq!(harness.state().settings.world_seed, Some(77));
    }

    #[test]
    fn controls_leave_what_nobody_touches() {
        let settings = Settings {
            sea_level_m: Some(8999.5),
            tree_seed: Some(9),
            world_seed: Some(4),
            exaggeration: 37.5,
            ..bare()
        };
        let harness = harness(settings.clone());
        assert_eq!(harness.state().settings, settings);
        for name in ["Exaggeration", "Sea", "Sea level", "Sea level, number", "Trees", "Tree seed", "World seed"] {
            assert!(widget(&harness, name).is_some(), "{name}");
        }
    }
}
