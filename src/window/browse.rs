//! The system's dialog for files and folders, on a thread of its own, so that no frame waits for it.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use rfd::{AsyncFileDialog, FileHandle};

use super::background::Background;

/// Hardly anybody closes a dialog faster than this. A dialog that ends sooner, without a choice, was never shown: no
/// portal for dialogs answers, and `rfd` says so only in a log.
const SHOWN: Duration = Duration::from_millis(800);

/// The kind of a choice in the dialog of the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DialogKind {
    /// A file of any kind that hachure opens.
    File,
    /// A folder of height files.
    Folder,
}

/// The end of a dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Chosen {
    /// The user chose this.
    Path(PathBuf),
    /// The user closed the dialog.
    Nothing,
    /// No dialog could be shown.
    NoDialog,
}

/// The dialog, if one is open.
#[derive(Default)]
pub(super) struct Browser {
    done: Option<Background<Chosen>>,
}

impl Browser {
    /// Opens the dialog, unless one is open. `wake` is called when it ends.
    pub(super) fn open(&mut self, kind: DialogKind, parent: &winit::window::Window, wake: impl Fn() + Send + 'static) {
        let dialog = AsyncFileDialog::new().set_parent(parent);
        // The dialog is created on this thread, because macOS requires that, and awaited on another.
        let picked: std::pin::Pin<Box<dyn Future<Output = Option<FileHandle>> + Send>> = match kind {
            DialogKind::File => Box::pin(dialog.set_title("Open a world, a style or a camera path").pick_file()),
            DialogKind::Folder => Box::pin(dialog.set_title("Open a folder of height files").pick_folder()),
        };
        self.wait_for(move || pollster::block_on(picked).map(|file| file.path().to_owned()), wake);
    }

    fn wait_for(
        &mut self,
        dialog: impl FnOnce() -> Option<PathBuf> + Send + 'static,
        wake: impl Fn() + Send + 'static,
    ) {
        if self.done.is_some() {
            return;
        }
        let work = move || {
            let begun = Instant::now();
            let path = dialog();
            chosen(path, begun.elapsed(), may_show())
        };
        self.done = Some(Background::start("dialog", work, wake));
    }

    /// Takes the end of the dialog; `None` while it is open, or if there is none.
    pub(super) fn take(&mut self) -> Option<Chosen> {
        let chosen = self.done.as_ref()?.take()?.unwrap_or(Chosen::NoDialog);
        self.done = None;
        Some(chosen)
    }
}

fn chosen(path: Option<PathBuf>, after: Duration, may_show: bool) -> Chosen {
    match path {
        Some(path) => Chosen::Path(path),
        None if !may_show || after < SHOWN => Chosen::NoDialog,
        None => Chosen::Nothing,
    }
}

/// Returns whether the system may be able to show a dialog. Without a session bus there is no portal, and `rfd` then
/// tries the program zenity.
#[cfg(target_os = "linux")]
fn may_show() -> bool {
    let var = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let has_bus = var("DBUS_SESSION_BUS_ADDRESS").is_some()
        || var("XDG_RUNTIME_DIR").is_some_and(|folder| PathBuf::from(folder).join("bus").exists());
    let has_zenity = || {
        let folders = var("PATH").unwrap_or_default();
        std::env::split_paths(&folders).any(|folder| folder.join("zenity").is_file())
    };
    has_bus || has_zenity()
}

/// Returns whether the system may be able to show a dialog.
#[cfg(not(target_os = "linux"))]
fn may_show() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    fn end_of(dialog: impl FnOnce() -> Option<PathBuf> + Send + 'static) -> Option<Chosen> {
        let mut browser = Browser::default();
        let (sender, woken) = channel();
        browser.wait_for(dialog, move || _ = sender.send(()));
        woken.recv_timeout(Duration::from_secs(20)).ok()?;
        let chosen = browser.take();
        assert_eq!(browser.take(), None, "a dialog ends once");
        chosen
    }

    #[test]
    fn a_dialog_that_never_appeared_is_told_from_one_that_was_closed() {
        assert_eq!(end_of(|| Some("a.tif".into())), Some(Chosen::Path("a.tif".into())));
        assert_eq!(end_of(|| None), Some(Chosen::NoDialog));
        assert_eq!(chosen(None, 2 * SHOWN, true), Chosen::Nothing);
        assert_eq!(chosen(None, 2 * SHOWN, false), Chosen::NoDialog, "a slow machine without a portal");
        assert_eq!(end_of(|| panic!("planted")), Some(Chosen::NoDialog));
    }
}
