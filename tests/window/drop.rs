//! Drops a file on a window as a file manager does, by the protocol XDND.

use std::path::Path;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, PropMode, SELECTION_NOTIFY_EVENT,
    SelectionNotifyEvent, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// The version of the protocol.
const VERSION: u32 = 5;
/// Longest wait for the other side.
const PATIENCE: Duration = Duration::from_secs(60);

/// Drops `file` on the window with this number (as xdotool prints it) at a place of the display. Returns whether the
/// window has taken it.
pub(crate) fn file(display: &str, window: &str, file: &Path, [x, y]: [u32; 2]) -> bool {
    let (connection, screen) = RustConnection::connect(Some(display)).unwrap();
    let root = connection.setup().roots[screen].root;
    let target: u32 = window.parse().unwrap();
    let source = connection.generate_id().unwrap();
    let aux = CreateWindowAux::new();
    connection.create_window(0, source, root, 0, 0, 1, 1, 0, WindowClass::INPUT_OUTPUT, 0, &aux).unwrap();
    let atom = |name: &str| connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
    let (list, selection, copy) = (atom("text/uri-list"), atom("XdndSelection"), atom("XdndActionCopy"));
    connection.set_selection_owner(source, selection, x11rb::CURRENT_TIME).unwrap();
    let send = |kind: &str, data: [u32; 5]| {
        let message = ClientMessageEvent::new(32, target, atom(kind), data);
        connection.send_event(false, target, EventMask::NO_EVENT, message).unwrap();
        connection.flush().unwrap();
    };
    let uri = format!("file://{}\r\n", file.display());
    let [status, finished] = [atom("XdndStatus"), atom("XdndFinished")];
    send("XdndEnter", [source, VERSION << 24, list, 0, 0]);
    send("XdndPosition", [source, 0, x << 16 | y, 0, copy]);
    let begun = Instant::now();
    let (mut has_read, mut may_drop, mut is_dropped) = (false, false, false);
    while begun.elapsed() < PATIENCE {
        if has_read && may_drop && !is_dropped {
            send("XdndDrop", [source, 0, 0, 0, 0]);
            is_dropped = true;
        }
        match connection.poll_for_event().unwrap() {
            Some(Event::SelectionRequest(asked)) => {
                connection
                    .change_property8(PropMode::REPLACE, asked.requestor, asked.property, list, uri.as_bytes())
                    .unwrap();
                let notice = SelectionNotifyEvent {
                    response_type: SELECTION_NOTIFY_EVENT,
                    sequence: 0,
                    time: asked.time,
                    requestor: asked.requestor,
                    selection: asked.selection,
                    target: asked.target,
                    property: if asked.target == list { asked.property } else { AtomEnum::NONE.into() },
                };
                connection.send_event(false, asked.requestor, EventMask::NO_EVENT, notice).unwrap();
                connection.flush().unwrap();
                has_read = true;
            }
            Some(Event::ClientMessage(message)) if message.type_ == status => {
                may_drop = message.data.as_data32()[1] & 1 == 1;
            }
            Some(Event::ClientMessage(message)) if message.type_ == finished => return true,
            Some(_) => {}
            None => std::thread::sleep(Duration::from_millis(10)),
        }
    }
    false
}
