//! The widgets that a screen reader cannot name, for the tests of panels.

use egui::Rect;
use egui::accesskit::{Action, Role};
use egui_kittest::Harness;
use egui_kittest::kittest::NodeT as _;

/// A widget that can have the keyboard focus.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::window) struct Focusable {
    pub name: String,
    pub role: Role,
    pub rect: Rect,
}

/// Returns the widgets that can have the keyboard focus.
pub(in crate::window) fn focusable<S>(harness: &Harness<'_, S>) -> Vec<Focusable> {
    let nodes = harness.root().children_recursive();
    let nodes = nodes.filter(|node| node.accesskit_node().data().supports_action(Action::Focus));
    let all = nodes.map(|node| Focusable {
        name: node.accesskit_node().label().unwrap_or_default().trim().to_owned(),
        role: node.accesskit_node().role(),
        rect: node.rect(),
    });
    // A window has the focus only as a whole.
    all.filter(|widget| !matches!(widget.role, Role::Window | Role::GenericContainer)).collect()
}

/// Returns the widgets that can have the keyboard focus and have no name.
pub(in crate::window) fn unnamed<S>(harness: &Harness<'_, S>) -> Vec<Focusable> {
    focusable(harness).into_iter().filter(|widget| widget.name.is_empty()).collect()
}

/// Returns the names that several widgets with the same role have.
pub(in crate::window) fn repeated<S>(harness: &Harness<'_, S>) -> Vec<String> {
    let all = focusable(harness);
    let is_same = |a: &Focusable, b: &Focusable| (&a.name, a.role) == (&b.name, b.role);
    let is_repeated = |widget: &&Focusable| all.iter().filter(|other| is_same(other, widget)).count() > 1;
    all.iter().filter(is_repeated).map(|widget| widget.name.clone()).collect()
}

#[test]
fn widgets_without_a_name_are_found() {
    let mut value = 1.0_f32;
    let (mut is_on, mut text) = (false, String::new());
    // egui_kittest itself panics in a frame that has such widgets.
    let harness = Harness::builder().with_size(egui::vec2(400.0, 300.0)).with_accessibility_check(false);
    let mut harness = harness.build_ui(|ui| {
        ui.label("a text is no widget");
        ui.add(egui::DragValue::new(&mut value));
        ui.checkbox(&mut is_on, "");
        ui.add(egui::TextEdit::singleline(&mut text));
        _ = ui.button("Named");
        ui.push_id("again", |ui| _ = ui.button("Named"));
        let named = ui.add(egui::Slider::new(&mut value, 0.0..=1.0).show_value(false));
        ui.ctx().accesskit_node_builder(named.id, |node| node.set_label("A slider"));
    });
    harness.run();
    let roles: Vec<Role> = unnamed(&harness).into_iter().map(|widget| widget.role).collect();
    assert_eq!(roles, [Role::SpinButton, Role::CheckBox, Role::TextInput]);
    assert_eq!(focusable(&harness).len(), 6);
    assert_eq!(repeated(&harness), ["Named", "Named"]);
}
