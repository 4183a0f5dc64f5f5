//! Where the workspace is and what `cargo metadata` says about its members.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::process::cargo;

/// The workspace's root folder: of the workspace that cargo runs this from, which may share a target folder with another copy.
pub(crate) fn root() -> PathBuf {
    let here = std::env::var_os("CARGO_MANIFEST_DIR");
    let here = here.as_deref().map_or(Path::new(env!("CARGO_MANIFEST_DIR")), Path::new);
    here.parent().unwrap_or(here).to_path_buf()
}

/// The part of `cargo metadata` that the pipelines need.
#[derive(Debug, Deserialize)]
pub(crate) struct Metadata {
    /// The workspace's members.
    pub(crate) packages: Vec<Package>,
}

/// One member of the workspace.
#[derive(Debug, Deserialize)]
pub(crate) struct Package {
    /// Its name.
    pub(crate) name: String,
    /// What its manifest asks for, of every kind (normal, dev, build).
    pub(crate) dependencies: Vec<Dependency>,
    /// What can be built from it.
    pub(crate) targets: Vec<Target>,
}

/// One dependency as declared in a manifest.
#[derive(Debug, Deserialize)]
pub(crate) struct Dependency {
    /// The name of the package, whatever it is renamed to.
    pub(crate) name: String,
    /// `dev` or `build`; none for a normal one.
    #[serde(default)]
    pub(crate) kind: Option<String>,
}

impl Dependency {
    /// Whether only tests, examples and benches see it.
    pub(crate) fn is_dev(&self) -> bool {
        self.kind.as_deref() == Some("dev")
    }
}

/// Something that cargo builds: a library, a binary, a test, a bench.
#[derive(Debug, Deserialize)]
pub(crate) struct Target {
    /// Its name.
    pub(crate) name: String,
    /// Its kinds, for example `bench`.
    pub(crate) kind: Vec<String>,
}

impl Metadata {
    /// Asks cargo; touches neither the network nor the lock file.
    ///
    /// # Errors
    /// When a manifest does not parse, with cargo's own words.
    pub(crate) fn load() -> Result<Self> {
        let mut command = cargo(["metadata", "--format-version=1", "--no-deps", "--offline"]);
        let output = command.stdin(Stdio::null()).output().context("cannot start cargo")?;
        if !output.status.success() {
            bail!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr).trim());
        }
        serde_json::from_slice(&output.stdout).context("cargo metadata answered in an unknown form")
    }
}
