//! `cargo xtask demo`: the main job from nothing to a trained one-step policy.

use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::Result;

use crate::process::{self, Failure, cargo, say};

const CONFIG: &str = "configs/quickstart.toml";

/// Build `reseflow` and run the quickstart: simulate demonstrations, train, evaluate, roll out.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask demo\n  \
    cargo xtask demo -- --help                     what may follow\n  \
    cargo xtask demo --set train.batch_size=8      change one key of configs/quickstart.toml")]
pub(crate) struct Args {
    /// Handed on to `reseflow run configs/quickstart.toml`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub(crate) passed_on: Vec<String>,
}

/// Builds in release and runs the quickstart.
pub(crate) fn run(args: &Args) -> Result<()> {
    require_c_compiler()?;
    say("demo 1/2: building reseflow in release (a first build takes several minutes)");
    let started = Instant::now();
    process::run(
        "the build of reseflow",
        &mut cargo(["build", "--release", "--locked", "--package", "reseflow"]),
    )?;
    say(&format!("demo 1/2: built in {:.0} s", started.elapsed().as_secs_f64()));

    let started = Instant::now();
    let mut reseflow =
        cargo(["run", "--quiet", "--release", "--locked", "--package", "reseflow", "--", "run"]);
    say(&format!("demo 2/2: reseflow run {CONFIG}"));
    process::run("the quickstart", reseflow.arg(CONFIG).args(&args.passed_on))?;
    say(&format!("demo 2/2: done in {:.0} s after the build", started.elapsed().as_secs_f64()));
    Ok(())
}

/// The allocator is C: without a compiler the build would fail minutes in, with a page of output.
fn require_c_compiler() -> Result<()> {
    let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
    let mut probe = Command::new(&compiler);
    probe.arg("--version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if probe.status().is_ok_and(|status| status.success()) {
        return Ok(());
    }
    let compiler = compiler.to_string_lossy();
    Err(Failure::new(format!(
        "no C compiler answers as `{compiler}`; on Debian, `apt-get install -y build-essential` installs one"
    ))
    .into())
}
