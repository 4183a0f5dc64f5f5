//! Running other programs: what is about to run is said, and what failed is named.

use std::fmt;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, Result};

use crate::workspace;

/// A program that ran and did not succeed; its exit code becomes ours.
#[derive(Debug)]
pub(crate) struct Failure {
    what: String,
    code: Option<i32>,
}

impl Failure {
    /// A failure of our own finding, such as a rule that does not hold: exit code 1.
    pub(crate) fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), code: Some(1) }
    }

    /// The exit code of the program that failed, 1 where it was killed.
    pub(crate) fn exit_code(&self) -> ExitCode {
        let code = self.code.and_then(|code| u8::try_from(code).ok()).filter(|code| *code != 0);
        ExitCode::from(code.unwrap_or(1))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for Failure {}

/// The cargo that started us (rustup's choice for this workspace), in the workspace root, with these arguments.
pub(crate) fn cargo<S: AsRef<str>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(workspace::root());
    command.args(arguments.into_iter().map(|argument| argument.as_ref().to_owned()));
    command
}

/// `reseflow`, built in release and copied aside, so that sources which change during hours of runs change none of them.
#[derive(Debug)]
pub(crate) struct Program(PathBuf);

impl Program {
    /// Builds it; the copy lies in `folder`.
    ///
    /// # Errors
    /// A [`Failure`] where the build failed, and a copy that cannot be made.
    pub(crate) fn build(folder: &Path) -> Result<Self> {
        say("building reseflow in release (a first build takes several minutes)");
        let build = ["build", "--release", "--locked", "--package", "reseflow"];
        run("the build of reseflow", &mut cargo(build))?;
        let output = cargo(["metadata", "--no-deps", "--locked", "--format-version", "1"])
            .stderr(Stdio::inherit())
            .output()
            .context("cannot start cargo metadata")?;
        let metadata: serde_json::Value =
            serde_json::from_slice(&output.stdout).context("reading cargo metadata")?;
        let target =
            metadata["target_directory"].as_str().context("cargo metadata names no target folder")?;
        let name = format!("reseflow{}", std::env::consts::EXE_SUFFIX);
        let built = Path::new(target).join("release").join(&name);
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        let copy = folder.join(&name);
        // Not over a program that may be running.
        let partial = folder.join(format!("{name}.partial"));
        std::fs::copy(&built, &partial).with_context(|| built.display().to_string())?;
        std::fs::rename(&partial, &copy).with_context(|| copy.display().to_string())?;
        Ok(Self(copy))
    }

    /// The program with these words, in the workspace root.
    pub(crate) fn with(&self, words: &[String]) -> Command {
        let mut command = Command::new(&self.0);
        command.current_dir(workspace::root()).args(words);
        command
    }
}

/// Whether `cargo <subcommand>` exists here.
pub(crate) fn has_cargo_tool(subcommand: &str) -> bool {
    let mut probe = cargo([subcommand, "--version"]);
    probe.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    probe.status().is_ok_and(|status| status.success())
}

/// Runs `command` with our terminal.
///
/// # Errors
/// A [`Failure`] that starts with `what` where the program ran and failed.
pub(crate) fn run(what: &str, command: &mut Command) -> Result<()> {
    announce(command);
    run_aside(what, command)
}

/// Runs `command` without a word; its output goes where the caller has sent it.
///
/// # Errors
/// As [`run`].
pub(crate) fn run_aside(what: &str, command: &mut Command) -> Result<()> {
    let status = command.stdin(Stdio::null()).status().with_context(|| cannot_start(command))?;
    judge(what, command, status)
}

/// Like [`run`], but hands every line of standard output to `each_line` after passing it on.
///
/// # Errors
/// As [`run`].
pub(crate) fn run_reading_lines(
    what: &str,
    command: &mut Command,
    mut each_line: impl FnMut(&str),
) -> Result<()> {
    announce(command);
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().with_context(|| cannot_start(command))?;
    if let Some(output) = child.stdout.take() {
        for line in BufReader::new(output).split(b'\n') {
            let line = line.context("reading the output of a test")?;
            let line = String::from_utf8_lossy(&line);
            say(&line);
            each_line(&line);
        }
    }
    let status = child.wait()?;
    judge(what, command, status)
}

fn judge(what: &str, command: &Command, status: std::process::ExitStatus) -> Result<()> {
    if status.success() {
        return Ok(());
    }
    let what = format!("{what} failed ({status}): {}", printable(command));
    Err(Failure { what, code: status.code() }.into())
}

fn cannot_start(command: &Command) -> String {
    format!("cannot start `{}`", command.get_program().to_string_lossy())
}

fn announce(command: &Command) {
    say(&format!("$ {}", printable(command)));
}

/// The command as one would type it.
fn printable(command: &Command) -> String {
    let program = std::path::Path::new(command.get_program());
    let mut text = program.file_name().unwrap_or(program.as_os_str()).to_string_lossy().into_owned();
    for argument in command.get_args() {
        text.push(' ');
        text.push_str(&argument.to_string_lossy());
    }
    text
}

/// Prints one line. A closed pipe is no reason to stop: the exit code says what happened.
pub(crate) fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Prints one line of complaint.
pub(crate) fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "error: {line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_program_is_named_and_its_exit_code_kept() {
        let error = run("the build", Command::new("sh").args(["-c", "exit 3"])).unwrap_err();
        let failure = error.downcast_ref::<Failure>().unwrap();
        assert_eq!(failure.code, Some(3));
        assert!(failure.to_string().starts_with("the build failed"), "{failure}");
        assert!(failure.to_string().ends_with("sh -c exit 3"), "{failure}");
    }

    #[test]
    fn a_missing_program_is_named() {
        let error = run("nothing", &mut Command::new("no-such-program-here")).unwrap_err();
        assert!(format!("{error:#}").contains("no-such-program-here"), "{error:#}");
    }

    #[test]
    fn every_line_is_read_before_failure_is_reported() {
        let mut lines = Vec::new();
        let result =
            run_reading_lines("it", Command::new("sh").args(["-c", "echo one; echo two; exit 1"]), |line| {
                lines.push(line.to_owned());
            });
        assert!(result.is_err());
        assert_eq!(lines, ["one", "two"]);
    }
}
