//! The options of the export dialog, by kind.

use egui::{DragValue, RichText, Ui};

use super::name;
use crate::picture::aov::CHANNELS;
use crate::studio::export::{Export, Kind, STEREO};

/// The sides of a picture that the dialog offers, in pixels.
const PIXELS: std::ops::RangeInclusive<u32> = 1..=1 << 20;
/// Paper sizes of the list; others are typed.
const PAPERS: [&str; 7] = ["a0", "a1", "a2", "a3", "a4", "letter", "tabloid"];

/// Adds the options of a kind.
pub(super) fn show(ui: &mut Ui, export: &mut Export) {
    let endings = export.kind.endings();
    if endings.len() > 1 {
        row(ui, "Format", |ui| {
            for ending in endings {
                if ui.selectable_label(export.ending() == *ending, format!(".{ending}")).clicked() {
                    export.set_ending(ending);
                }
            }
            if export.kind == Kind::Film && ui.selectable_label(export.is_frames(), "frames").clicked() {
                export.set_frames();
            }
        });
    }
    let may_be_on_paper = matches!(export.kind, Kind::Picture | Kind::Lines | Kind::Map);
    if may_be_on_paper && export.ending() != "geojson" {
        row(ui, "Size", |ui| {
            ui.selectable_value(&mut export.is_on_paper, false, "pixels");
            ui.selectable_value(&mut export.is_on_paper, true, "paper");
        });
    }
    if export.has_paper() {
        paper_options(ui, export);
    }
    if !export.has_paper() || export.kind == Kind::Lines {
        row(ui, "Pixels", |ui| {
            let [width, height] = &mut export.size_px;
            name(&ui.add(DragValue::new(width).range(PIXELS)), "Width in pixels");
            ui.label("×");
            name(&ui.add(DragValue::new(height).range(PIXELS)), "Height in pixels");
        });
    }
    if export.has_samples() {
        row(ui, "Samples per pixel", |ui| {
            name(&ui.add(DragValue::new(&mut export.samples).range(1..=64)), "Samples per pixel");
        });
    }
    kind_options(ui, export);
    if export.has_title() {
        row(ui, "Title", |ui| {
            let field = egui::TextEdit::singleline(&mut export.title).hint_text("none").desired_width(150.0);
            name(&ui.add(field), "Title below the picture");
        });
        if !export.title.trim().is_empty() {
            row(ui, "Credits", |ui| {
                let field = egui::TextEdit::singleline(&mut export.credits).hint_text("none").desired_width(150.0);
                name(&ui.add(field), "Credits in the title block");
            });
            ui.checkbox(&mut export.has_legend, "Legend");
        }
    }
}

/// Adds the options of paper.
fn paper_options(ui: &mut Ui, export: &mut Export) {
    row(ui, "Paper", |ui| {
        paper(ui, "Paper", &mut export.paper);
        if export.kind != Kind::Lines {
            ui.selectable_value(&mut export.is_portrait, false, "landscape");
            ui.selectable_value(&mut export.is_portrait, true, "portrait");
        }
    });
    if export.kind == Kind::Lines {
        row(ui, "Margin", |ui| {
            let value = DragValue::new(&mut export.margin_mm).range(0.0..=500.0).suffix(" mm");
            name(&ui.add(value), "Margin in millimetres");
        });
    } else {
        row(ui, "Dots per inch", |ui| {
            name(&ui.add(DragValue::new(&mut export.dpi).range(10.0..=2400.0)), "Dots per inch");
        });
    }
}

/// Adds the options that only one kind has.
fn kind_options(ui: &mut Ui, export: &mut Export) {
    match export.kind {
        Kind::Picture => {}
        Kind::Sheets => {
            row(ui, "Sheets", |ui| paper(ui, "Paper of the sheets", &mut export.sheets));
            row(ui, "Overlap", |ui| {
                let value = DragValue::new(&mut export.overlap_mm).range(0.0..=100.0).suffix(" mm");
                name(&ui.add(value), "Overlap in millimetres");
            });
        }
        Kind::Lines => pens(ui, export),
        Kind::Exr => {
            ui.label(RichText::new("Channels").weak());
            ui.horizontal_wrapped(|ui| {
                for channel in CHANNELS {
                    let mut is_on = export.channels.contains(&channel);
                    if ui.checkbox(&mut is_on, channel).changed() {
                        // In the order of the list, so that the command line does not depend on the clicks.
                        let before = std::mem::take(&mut export.channels);
                        let is_in = |known: &&&str| if **known == channel { is_on } else { before.contains(known) };
                        export.channels = CHANNELS.iter().filter(is_in).copied().collect();
                    }
                }
            });
        }
        Kind::Map => {
            row(ui, "Area", |ui| {
                let mut is_whole = export.map_width_m.is_none();
                ui.selectable_value(&mut is_whole, true, "all land");
                ui.selectable_value(&mut is_whole, false, "around the camera");
                if is_whole != export.map_width_m.is_none() {
                    export.map_width_m = (!is_whole).then_some(5000.0);
                }
            });
            if let Some(width_m) = &mut export.map_width_m {
                row(ui, "Width", |ui| {
                    let value = DragValue::new(width_m).range(1.0..=1e7).speed(50.0).suffix(" m");
                    name(&ui.add(value), "Width of the map in metres");
                });
            }
            if export.has_title() {
                ui.checkbox(&mut export.is_framed, "Frame with coordinates");
            }
            if export.ending() == "geojson" {
                ui.checkbox(&mut export.is_wgs84, "Longitudes and latitudes (WGS 84)");
                pens(ui, export);
            }
        }
        Kind::Stereo => row(ui, "Eyes", |ui| {
            let list = egui::ComboBox::from_id_salt("eyes of the export").selected_text(export.eyes);
            let list = list.show_ui(ui, |ui| {
                STEREO.iter().for_each(|eyes| _ = ui.selectable_value(&mut export.eyes, *eyes, *eyes));
            });
            name(&list.response, "Layout of the eyes");
        }),
        Kind::Film => {
            row(ui, "Camera path", |ui| {
                let hint = "path.csv, or tour";
                let field = egui::TextEdit::singleline(&mut export.path).hint_text(hint).desired_width(130.0);
                name(&ui.add(field), "Camera path of the film");
            });
            row(ui, "Frames per second", |ui| {
                name(&ui.add(DragValue::new(&mut export.fps).range(1.0..=120.0)), "Frames per second");
            });
        }
    }
}

fn pens(ui: &mut Ui, export: &mut Export) {
    row(ui, "Pens", |ui| {
        ui.selectable_value(&mut export.pens, 0, "any width");
        for (count, words) in [(1, "1 pen"), (2, "2 pens"), (3, "3 pens")] {
            name(&ui.selectable_value(&mut export.pens, count, count.to_string()), words);
        }
    });
}

/// Adds a list of paper sizes and a field for others.
fn paper(ui: &mut Ui, label: &str, paper: &mut String) {
    let hint = "a0 to a6, letter, legal, tabloid, or WIDTHxHEIGHT in millimetres";
    let field = ui.add(egui::TextEdit::singleline(paper).desired_width(52.0)).on_hover_text(hint);
    name(&field, label);
    let list = egui::ComboBox::from_id_salt(label).selected_text("").width(18.0).show_ui(ui, |ui| {
        PAPERS.iter().for_each(|known| _ = ui.selectable_value(paper, (*known).to_owned(), *known));
    });
    name(&list.response, &format!("{label}: list of sizes"));
}

fn row(ui: &mut Ui, label: &str, content: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(label).weak());
        content(ui);
    });
}
