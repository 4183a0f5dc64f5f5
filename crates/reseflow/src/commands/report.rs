//! `reseflow report`: finished runs as tables and figures.

use crate::cli::ReportArgs;
use crate::output::{Table, Terminal};
use crate::report::write_report;

/// Runs the command.
pub(super) fn execute(args: &ReportArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let summary = write_report(&args.runs, &args.out, terminal)?;
    let mut table = Table::facts("report", &summary.html.display().to_string());
    table.fact("runs", summary.runs.join(", "));
    table.fact("tables", summary.markdown.display());
    table.fact(
        "figures",
        format!("{} files in {}", summary.figures.len(), args.out.join("figures").display()),
    );
    for sentence in &summary.left_out {
        table.fact("left out", sentence);
    }
    terminal.say(table);
    terminal.machine(&summary)
}
