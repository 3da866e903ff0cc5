//! The contents of the panel in the headset, and how buttons and sticks act on it.
//!
//! Lists are open while a button is held: the stick selects, and letting go applies. This module depends on neither
//! OpenXR nor GPUs.

use glam::DVec2;

use super::controllers::Controller;
use super::panel::{Body, Page, Slider};
use super::styles::Styles;
use crate::style::controls::{Control, END};

/// Time for which a button with two meanings must be held for the second one.
const LONG_S: f64 = 0.4;
/// Deflection of a stick that selects.
const DEFLECTION: f64 = 0.6;
/// A stick that has returned to below this deflection is at rest.
const REST: f64 = 0.3;
/// Time until a stick that stays deflected selects again, and from then on.
const REPEATS_S: [f64; 2] = [0.4, 0.12];
/// Step by which a push moves a control of the style.
const STEP: i8 = 10;

/// Input of the hands for the panel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MenuInput {
    /// Whether the button of the list of styles is held.
    pub styles: bool,
    /// Whether the button of the five controls is held.
    pub adjust: bool,
    /// Whether the button of the help was pressed in this frame.
    pub help: bool,
    /// Whether any other button was pressed in this frame, or a stick is pushed.
    pub any: bool,
    /// The sum of both sticks, −1 to 1 on each axis.
    pub stick: DVec2,
    /// Presses of the two free buttons of a controller without sticks, in this frame.
    pub picks: [bool; 2],
}

/// A request of the user in the panel.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MenuAction {
    /// Draws in another style.
    Style(String),
    /// Moves a control of the current style.
    Move(Control, i8),
    /// The last movement is over.
    Release,
}

/// The panel's state.
#[derive(Clone, Debug)]
pub(super) struct Menu {
    open: Open,
    repeater: Repeater,
    /// Whether the sticks have not been at rest since a list was closed.
    sticks_are_spent: bool,
    /// The button that opened the last list has not been released since.
    is_cancelled: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Open {
    Nothing,
    /// The controls of the flight. At the start the page also shows the current work.
    Help,
    /// The selected column and row.
    Styles(usize, usize),
    /// The selected control.
    Adjust(usize),
}

impl Menu {
    /// Creates a menu that shows the controls.
    pub(super) fn new() -> Self {
        Self { open: Open::Help, repeater: Repeater::default(), sticks_are_spent: false, is_cancelled: false }
    }

    /// Returns whether the panel is seen.
    pub(super) fn is_open(&self) -> bool {
        self.open != Open::Nothing
    }

    /// Returns whether the controllers operate the panel, so that the flight must ignore them.
    pub(super) fn has_hands(&self) -> bool {
        matches!(self.open, Open::Styles(..) | Open::Adjust(_)) || self.sticks_are_spent
    }

    /// Closes a list without applying it, because the session gets no input.
    pub(super) fn cancel(&mut self) {
        if matches!(self.open, Open::Styles(..) | Open::Adjust(_)) {
            self.open = Open::Nothing;
        }
        (self.is_cancelled, self.sticks_are_spent) = (true, true);
    }

    /// Advances by `step_s`. Returns the actions to carry out, and whether the panel was opened and must be put in
    /// front of the eyes.
    pub(super) fn advance(&mut self, input: &MenuInput, step_s: f64, styles: &Styles) -> (Vec<MenuAction>, bool) {
        let before = std::mem::discriminant(&self.open);
        let was_open = self.is_open();
        self.sticks_are_spent &= input.stick.length() > REST;
        self.is_cancelled &= input.styles || input.adjust;
        let push = self.repeater.advance(input.stick, step_s).or_else(|| self.pick(input));
        let mut actions = Vec::new();
        match &mut self.open {
            Open::Nothing | Open::Help => {
                if input.styles && !self.is_cancelled {
                    let (column, row) = styles.place();
                    self.open = Open::Styles(column, row);
                } else if input.adjust && !self.is_cancelled {
                    self.open = Open::Adjust(0);
                } else if input.help {
                    self.open = if was_open { Open::Nothing } else { Open::Help };
                } else if input.any && was_open {
                    self.open = Open::Nothing;
                }
            }
            Open::Styles(column, row) => {
                if input.help {
                    self.cancel();
                } else if !input.styles {
                    actions.extend(styles.at(*column, *row).map(|name| MenuAction::Style(name.to_owned())));
                    (self.open, self.sticks_are_spent) = (Open::Nothing, true);
                } else if let Some(push) = push {
                    (*column, *row) = styles.moved((*column, *row), push);
                }
            }
            Open::Adjust(chosen) => {
                if input.help || !input.adjust {
                    actions.push(MenuAction::Release);
                    (self.is_cancelled, self.sticks_are_spent) = (input.help, true);
                    self.open = Open::Nothing;
                } else if let Some(push) = push {
                    let last = Control::ALL.len() - 1;
                    match push {
                        Push::Up => *chosen = chosen.saturating_sub(1),
                        Push::Down => *chosen = (*chosen + 1).min(last),
                        Push::Next => *chosen = (*chosen + 1) % Control::ALL.len(),
                        Push::Left | Push::Right | Push::Around => {
                            let control = Control::ALL[*chosen];
                            let position = styles.position(control);
                            actions.push(MenuAction::Move(control, stepped(position, push)));
                        }
                    }
                }
            }
        }
        let is_new = self.is_open() && (!was_open || before != std::mem::discriminant(&self.open));
        (actions, is_new)
    }

    /// Returns the selection of a controller without sticks: one button goes on, the other one to the next column or
    /// control.
    fn pick(&self, input: &MenuInput) -> Option<Push> {
        let is_adjusting = matches!(self.open, Open::Adjust(_));
        match input.picks {
            [true, _] => Some(if is_adjusting { Push::Around } else { Push::Next }),
            [_, true] => Some(if is_adjusting { Push::Next } else { Push::Around }),
            _ => None,
        }
    }

    /// Returns the page that the panel shows. `doing` is the current work, with its progress from 0 to 1 if known.
    pub(super) fn page(
        &self,
        styles: &Styles,
        controller: &Controller,
        doing: Option<(String, Option<f32>)>,
        name: &str,
    ) -> Option<Page> {
        let [of_list, of_controls] = if controller.has_sticks() {
            ["Stick: choose. Let go: draw in it.", "Up, down: choose. Left, right: change."]
        } else {
            ["Left select: next. Left menu: column.", "Left select: change. Left menu: next."]
        };
        Some(match self.open {
            Open::Nothing => return None,
            Open::Help => {
                let (footer, done) = doing.unwrap_or(("Any button closes this.".to_owned(), None));
                Page { title: format!("hachure: {name}"), body: Body::Controls(controller.rows()), footer, done }
            }
            Open::Styles(column, row) => {
                let mut columns = styles.columns();
                columns[column].selected = Some(row);
                let title = "Styles".to_owned();
                Page { title, body: Body::Columns(columns), footer: of_list.to_owned(), done: None }
            }
            Open::Adjust(chosen) => {
                let slider = |(i, control): (usize, Control)| Slider {
                    name: control.name().to_owned(),
                    position: styles.position(control),
                    is_selected: i == chosen,
                    has_effect: control.without_effect(styles.style()).is_none(),
                };
                let sliders = Control::ALL.into_iter().enumerate().map(slider).collect();
                let title = format!("Adjust {}", styles.title());
                let help = Control::ALL[chosen].help().to_owned();
                Page { title, body: Body::Sliders(sliders, help), footer: of_controls.to_owned(), done: None }
            }
        })
    }
}

/// Returns the position of a control after a push.
fn stepped(position: i8, push: Push) -> i8 {
    match push {
        Push::Left => position.saturating_sub(STEP).max(-END),
        Push::Around if position >= END => -END,
        _ => position.saturating_add(STEP).min(END),
    }
}

/// A direction in which the selection moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Push {
    Up,
    Down,
    Left,
    Right,
    /// To the next choice, and from the last one to the first.
    Next,
    /// To the right, and from the end of a row to its beginning.
    Around,
}

/// Turns a deflected stick into pushes: one at once, and more while it stays deflected.
#[derive(Clone, Debug, Default)]
struct Repeater {
    direction: Option<Push>,
    left_s: f64,
}

impl Repeater {
    fn advance(&mut self, stick: DVec2, step_s: f64) -> Option<Push> {
        let is_upright = stick.y.abs() > stick.x.abs();
        let direction = match (is_upright, stick.abs().max_element() > DEFLECTION) {
            (_, false) => None,
            (true, _) => Some(if stick.y > 0.0 { Push::Up } else { Push::Down }),
            (false, _) => Some(if stick.x > 0.0 { Push::Right } else { Push::Left }),
        };
        if direction != self.direction {
            (self.direction, self.left_s) = (direction, REPEATS_S[0]);
            return direction;
        }
        self.left_s -= step_s.max(0.0);
        if self.left_s > 0.0 {
            return None;
        }
        self.left_s = REPEATS_S[1];
        direction
    }
}

/// Tells a short press of a button from a long one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LongPress {
    held_s: Option<f64>,
}

impl LongPress {
    /// Returns whether a short press ended in this frame, whether the button has been held for long, and whether that
    /// became true in this frame.
    pub(super) fn advance(&mut self, is_down: bool, step_s: f64) -> (bool, bool, bool) {
        let before_s = self.held_s;
        let is_long = |held_s: Option<f64>| held_s.is_some_and(|held_s| held_s >= LONG_S);
        self.held_s = is_down.then(|| before_s.map_or(0.0, |held_s| held_s + step_s.max(0.0)));
        let is_over = !is_down && before_s.is_some() && !is_long(before_s);
        (is_over, is_long(self.held_s), is_long(self.held_s) && !is_long(before_s))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::headset::controllers::CONTROLLERS;

    const STEP_S: f64 = 0.1;
    const HELD: MenuInput =
        MenuInput { styles: true, adjust: false, help: false, any: false, stick: DVec2::ZERO, picks: [false; 2] };
    const ADJUST: MenuInput = MenuInput { styles: false, adjust: true, ..HELD };
    const IDLE: MenuInput = MenuInput { styles: false, ..HELD };

    fn push(input: MenuInput, x: f64, y: f64) -> MenuInput {
        MenuInput { stick: DVec2::new(x, y), ..input }
    }

    fn run(menu: &mut Menu, styles: &Styles, inputs: &[MenuInput]) -> Vec<MenuAction> {
        inputs.iter().flat_map(|input| menu.advance(input, STEP_S, styles).0).collect()
    }

    #[test]
    fn letting_go_draws_in_the_selected_style() {
        let styles = Styles::of_nobody("ink").unwrap();
        let mut menu = Menu::new();
        let (down, up) = (push(HELD, 0.0, -1.0), push(HELD, 0.0, 1.0));
        let actions = run(&mut menu, &styles, &[HELD, down, HELD, down, HELD, up, HELD, IDLE]);
        assert_eq!(actions, [MenuAction::Style("pen".to_owned())]);
        assert!(!menu.is_open());
        // A stick that stays deflected for 1.5 s selects seven times: at once, after half a second, and then in every
        // second step.
        let actions = run(&mut menu, &styles, &[vec![HELD], vec![down; 15], vec![IDLE]].concat());
        assert_eq!(actions, [MenuAction::Style("wash".to_owned())]);
        // The help's button, and a session without input, choose nothing, and the button must be released first.
        let help = MenuInput { help: true, ..HELD };
        assert!(run(&mut menu, &styles, &[HELD, down, help, HELD, HELD, IDLE]).is_empty());
        assert!(!menu.is_open());
        run(&mut menu, &styles, &[HELD, down]);
        menu.cancel();
        assert!(!menu.is_open() && run(&mut menu, &styles, &[HELD, IDLE]).is_empty());
        // A stick that is still deflected does not fly.
        run(&mut menu, &styles, &[HELD, push(IDLE, 1.0, 0.0)]);
        assert!(menu.has_hands());
        run(&mut menu, &styles, &[IDLE]);
        assert!(!menu.has_hands());
    }

    #[test]
    fn controls_move_within_their_range() {
        let styles = Styles::of_nobody("ink").unwrap();
        let mut menu = Menu::new();
        let (down, right) = (push(ADJUST, 0.0, -1.0), push(ADJUST, 1.0, 0.0));
        let actions = run(&mut menu, &styles, &[ADJUST, down, right, ADJUST, push(ADJUST, -1.0, 0.0), IDLE]);
        let weight = Control::Weight;
        assert_eq!(actions, [MenuAction::Move(weight, 10), MenuAction::Move(weight, -10), MenuAction::Release]);
        assert_eq!(
            [(0, Push::Right), (95, Push::Right), (-95, Push::Left), (100, Push::Around)]
                .map(|(at, to)| stepped(at, to)),
            [10, 100, -100, -100]
        );
        // Two buttons are enough.
        let pick = |first, second| MenuInput { picks: [first, second], ..ADJUST };
        let actions = run(&mut menu, &styles, &[ADJUST, pick(false, true), pick(false, true), pick(true, false), IDLE]);
        assert_eq!(actions, [MenuAction::Move(Control::Contrast, 10), MenuAction::Release]);
    }

    #[test]
    fn the_first_button_closes_the_controls() {
        let styles = Styles::of_nobody("ink").unwrap();
        let mut menu = Menu::new();
        assert!(menu.advance(&IDLE, STEP_S, &styles) == (Vec::new(), false) && menu.is_open());
        menu.advance(&MenuInput { any: true, ..IDLE }, STEP_S, &styles);
        assert!(!menu.is_open());
        let help = MenuInput { help: true, ..IDLE };
        assert_eq!(menu.advance(&help, STEP_S, &styles), (Vec::new(), true));
        menu.advance(&help, STEP_S, &styles);
        assert!(!menu.is_open());
    }

    #[test]
    fn a_long_press_is_no_short_one() {
        let mut button = LongPress::default();
        let mut run = |downs: &[bool]| downs.iter().map(|down| button.advance(*down, STEP_S)).collect::<Vec<_>>();
        let nothing = (false, false, false);
        assert_eq!(run(&[true, true, false, false]), [nothing, nothing, (true, false, false), nothing]);
        let found = run(&[true, true, true, true, true, true, false]);
        assert_eq!(found[4..], [(false, true, true), (false, true, false), nothing]);
    }

    #[test]
    fn places_of_the_list_are_all_reached() {
        let styles = Styles::of_nobody("ink").unwrap();
        let mut seen = std::collections::BTreeSet::new();
        for push in [Push::Down, Push::Next] {
            let (mut place, mut count) = ((0, 0), 0);
            seen.clear();
            while seen.insert(place) {
                place = styles.moved(place, push);
                count += 1;
                assert!(count < 100);
            }
            assert!(seen.contains(&(0, 8)) && seen.contains(&(1, crate::style::names().len() - 1)), "{push:?}");
        }
        assert_eq!(styles.moved((1, 20), Push::Left), (0, 8));
        assert_eq!(styles.moved((1, 0), Push::Up), (0, 8));
    }

    #[test]
    fn every_text_fits() {
        let styles = Styles::of_nobody("pencil-lines").unwrap();
        let width = |text: &str| 28.0 * crate::lettering::Line::new(text).width();
        for controller in &CONTROLLERS {
            for [control, action] in controller.rows() {
                assert!(width(&control) < 330.0 && width(&action) < 600.0, "{control}: {action}");
            }
            let mut menu = Menu::new();
            for (name, input) in [("help", IDLE), ("styles", HELD), ("rest", IDLE), ("adjust", ADJUST)] {
                menu.advance(&input, STEP_S, &styles);
                let Some(page) = menu.page(&styles, controller, None, "mountain.tif") else { continue };
                assert!(width(&page.footer) < 936.0, "{}", page.footer);
                let kind = controller.profile.rsplit('/').next().unwrap_or_default();
                crate::headset::panel::tests::look(&format!("{name}-{kind}"), &page);
            }
        }
    }
}
