//! The one line with which a build without a feature reports that. CI builds one without both features and runs this.

use super::Place;

#[test]
fn what_is_left_out_is_reported() {
    let place = Place::empty();
    let fly = place.hachure(&["fly", "nowhere.tif"]);
    let fly = String::from_utf8_lossy(&fly.stderr).into_owned();
    let without_window =
        "hachure: this build of hachure has no window (feature `window`); use `hachure render` to draw into a file\n";
    assert_eq!(fly == without_window, cfg!(not(feature = "window")), "{fly}");

    let vr = place.error(&["fly", "nowhere.tif", "--vr"]);
    let without_headset = vr.starts_with("--vr: this build of hachure has no headset (feature `headset`");
    assert_eq!(without_headset, cfg!(not(feature = "headset")), "{vr}");

    // Nothing listens at this port: a build with a network reports that.
    let address = "http://127.0.0.1:9/land.tif";
    let error = place.error(&["render", address, "-o", "a.png"]);
    let without_network =
        format!("{address}: this build of hachure has no network access (it lacks the feature `network`)");
    assert_eq!(error == without_network, cfg!(not(feature = "network")), "{error}");
}
