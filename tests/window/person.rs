//! A person at the window, who sees where its widgets are.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::display::{Display, until};

/// How long a person waits for the effect of a click or of typed keys before repeating them.
const EFFECT: Duration = Duration::from_secs(20);

/// A widget as the window reports it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Widget {
    /// Left, top, right and bottom in pixels of the window.
    pub(crate) rect: [f64; 4],
    pub(crate) role: String,
    pub(crate) name: String,
    pub(crate) value: String,
    /// Whether a click on it has no effect.
    pub(crate) is_disabled: bool,
}

/// The window, and what it reports of itself.
pub(crate) struct Person<'a> {
    pub(crate) display: &'a Display,
    pub(crate) window: String,
    pub(crate) widgets: PathBuf,
    pub(crate) frame: Duration,
}

impl Person<'_> {
    pub(crate) fn all(&self) -> Vec<Widget> {
        let text = std::fs::read_to_string(&self.widgets).unwrap_or_default();
        let parse = |line: &str| {
            let parts: Vec<&str> = line.split('\t').collect();
            let [left, top, right, bottom, role, name, value, state] = parts[..] else { return None };
            let side = |text: &str| text.parse::<f64>().ok();
            Some(Widget {
                rect: [side(left)?, side(top)?, side(right)?, side(bottom)?],
                role: role.to_owned(),
                name: name.to_owned(),
                value: value.to_owned(),
                is_disabled: state == "disabled",
            })
        };
        text.lines().skip(1).filter_map(parse).collect()
    }

    /// Returns a widget when it is there and does not move any more: panels have their sizes after a few frames.
    pub(crate) fn find(&self, role: &str, name: &str) -> Widget {
        until(&format!("{role} {name}"), || {
            let before = self.see(role, name)?;
            std::thread::sleep(2 * self.frame + Duration::from_millis(100));
            self.see(role, name).filter(|widget| *widget == before)
        })
    }

    pub(crate) fn see(&self, role: &str, name: &str) -> Option<Widget> {
        self.all().into_iter().find(|widget| widget.role == role && widget.name == name)
    }

    /// Moves the mouse to a place of the window.
    pub(crate) fn point(&self, [x, y]: [f64; 2]) {
        let [x, y] = [x, y].map(|side| side.round().to_string());
        self.display.key(&["mousemove", "--window", &self.window, &x, &y]);
    }

    pub(crate) fn middle(widget: &Widget) -> [f64; 2] {
        let [left, top, right, bottom] = widget.rect;
        [0.5 * (left + right), 0.5 * (top + bottom)]
    }

    /// Clicks on a widget, once it is enabled.
    pub(crate) fn click(&self, role: &str, name: &str) {
        let widget =
            until(&format!("{role} {name}, enabled"), || Some(self.find(role, name)).filter(|it| !it.is_disabled));
        self.point(Self::middle(&widget));
        self.display.key(&["click", "1"]);
    }

    /// Clicks on a widget until that has an effect, which `effect` returns.
    pub(crate) fn click_until<T>(&self, role: &str, name: &str, effect: impl Fn() -> Option<T>) -> T {
        repeat(&format!("an effect of {role} {name}"), || self.click(role, name), effect)
    }

    /// Returns a widget whose name begins like this, if it is there.
    pub(crate) fn beginning(&self, role: &str, name: &str) -> Option<Widget> {
        self.all().into_iter().find(|widget| widget.role == role && widget.name.starts_with(name))
    }

    /// Types a text or a number in place of what a field has, until the field has it.
    pub(crate) fn fill(&self, role: &str, name: &str, text: &str) {
        let typed = || {
            self.click(role, name);
            self.keys(&["ctrl+a"]);
            self.display.key(&["type", "--delay", "15", text]);
            self.keys(&["Return"]);
        };
        repeat(&format!("{name}: {text}"), typed, || {
            self.see(role, name).filter(|widget| widget.value.starts_with(text))
        });
    }

    pub(crate) fn keys(&self, keys: &[&str]) {
        self.display.key(&[&["key"], keys].concat());
    }
}

/// Acts until that has an effect, which `effect` returns: a busy machine may lose a click. Each act has [`EFFECT`] to
/// have one, so that a second one does not undo the first; a repeated act is printed.
fn repeat<T>(what: &str, act: impl Fn(), effect: impl Fn() -> Option<T>) -> T {
    until(what, || {
        act();
        let begun = Instant::now();
        while begun.elapsed() < EFFECT {
            if let Some(done) = effect() {
                return Some(done);
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        println!("once more: {what}");
        None
    })
}
