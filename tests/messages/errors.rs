//! Tests the errors of the library: each message contains the words of its causes once.

use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

use hachure::internals::chain;
use hachure::pyramid::PyramidError;
use hachure::remote::RemoteError;
use hachure::scene::SceneError;
use hachure::scene::path::PathError;
use hachure::source::{GeoreferenceError, SourceError};
use hachure::style::{Style, StyleError};
use hachure::world::MeshError;
use hachure::world::TerrainError;
use hachure::world::WorldError;

/// Checks that a message contains the message of each cause once, and that the program adds nothing to it.
fn has_each_cause_once(error: &(dyn Error + 'static)) -> Result<(), String> {
    let message = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let words = error.to_string();
        if message.matches(&words).count() != 1 {
            return Err(format!("{message:?} does not say {words:?} once"));
        }
        cause = error.source();
    }
    if chain(error) == message { Ok(()) } else { Err(format!("{:?} is not {message:?}", chain(error))) }
}

#[derive(Debug, thiserror::Error)]
#[error("{words}")]
struct Planted {
    words: &'static str,
    source: io::Error,
}

#[test]
fn errors_tell_their_causes_once() {
    let path = || PathBuf::from("land/a.tif");
    let full = || io::Error::other("the disk is full");
    let open = || SourceError::Open { path: path(), source: full() };
    let remote = || RemoteError::Io { name: "b.tif".to_owned(), source: full() };
    let boxed = || -> Box<dyn Error + Send + Sync> { Box::new(Planted { words: "the block is odd", source: full() }) };
    let name = || "x".to_owned();
    let unknown = format!("{}[strokes]\nwidth_px = 3\ntexture = \"crayon\"\n", crate::toml::STYLE);
    let scene = || SceneError::Open { path: path(), cause: full() };
    let bad_scene = hachure::scene::Scene::parse(Path::new("s.toml"), "[world]\nx = 1\n").unwrap_err();
    let errors: Vec<Box<dyn Error>> = vec![
        Box::new(open()),
        Box::new(SourceError::Georeference { path: path(), source: GeoreferenceError::PixelSize }),
        Box::new(hachure::source::open(Path::new("none.tif"), &hachure::source::Silent).unwrap_err()),
        Box::new(remote()),
        Box::new(PyramidError::Io { path: path(), what: "writing", source: full() }),
        Box::new(PyramidError::Encode { path: path(), source: boxed() }),
        Box::new(PyramidError::Decode { path: path(), source: boxed() }),
        Box::new(PyramidError::Cache { folder: path(), source: boxed() }),
        Box::new(PyramidError::from(remote())),
        Box::new(PyramidError::Unread { source: open() }),
        Box::new(PyramidError::from(open())),
        Box::new(PyramidError::Load(Box::new(open()))),
        Box::new(Style::load("none.toml").unwrap_err()),
        Box::new(StyleError::ReadTexture { path: name(), source: full() }),
        Box::new(StyleError::ReadMarks { path: name(), source: full() }),
        Box::new(Style::parse("x.toml", "name = 3").unwrap_err()),
        Box::new(Style::parse("x.toml", &unknown).unwrap_err()),
        Box::new(Style::parse("x.toml", &unknown.replace("crayon", "none.toml")).unwrap_err()),
        Box::new(scene()),
        Box::new(PathError::Open { path: path(), cause: full() }),
        Box::new(WorldError::from(bad_scene)),
        Box::new(WorldError::from(PyramidError::from(open()))),
        Box::new(WorldError::Ground(std::sync::Arc::new(PyramidError::from(open())))),
        Box::new(WorldError::Terrain { name: name(), source: TerrainError::TooWide { width: 9, height: 9 } }),
        Box::new(WorldError::InScene { scene: "s.toml".into(), source: Box::new(PyramidError::from(open()).into()) }),
        Box::new(WorldError::from(MeshError::Read { path: path(), cause: name() })),
    ];
    for error in errors {
        has_each_cause_once(&*error).unwrap();
    }
    assert!(has_each_cause_once(&Planted { words: "the block is odd", source: full() }).is_err());
    assert!(has_each_cause_once(&Planted { words: "the disk is full: the disk is full", source: full() }).is_err());
}
