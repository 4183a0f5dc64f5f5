//! The arguments of `reseflow report`.

use std::path::PathBuf;

use clap::Args;

/// `reseflow report`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow report runs/quickstart --out report
  reseflow report runs/door runs/painting runs/triangle runs/coin_toss --out report

Writes report.html, which opens without a network, report.md with the same tables, figures/*.svg and *.png, results.json (the figures
for machines) and results.md (the tables in short). What a run does not hold is left out, with a sentence that says so.")]
pub struct ReportArgs {
    /// The folders of runs, the more important ones first
    #[arg(value_name = "RUN_FOLDER", required = true)]
    pub runs: Vec<PathBuf>,
    /// The report's folder
    #[arg(long, value_name = "FOLDER")]
    pub out: PathBuf,
}
