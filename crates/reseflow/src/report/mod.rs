//! Finished runs as one report: an HTML file that needs nothing else, the same tables as Markdown, every figure as SVG and PNG, and the
//! figures that README.md shows, for machines.

mod document;
mod figures;
mod gather;
mod html;
mod markdown;
mod page;
mod paper;
mod pooling;
#[cfg(test)]
mod readme;
mod results;
#[cfg(test)]
mod samples;
mod shipped;
mod study;
mod summary;
mod tables;
mod texts;

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::config::is_folder_name;
use crate::error::bad_input;
use crate::output::{OutputFile, OutputFolder, Terminal};
use document::Block;
use gather::Run;
use results::Results;
use study::Study;

const TITLE: &str = "ReSeFlow: the paper's benchmark, run here";

/// What was written.
#[derive(Debug, Serialize)]
pub struct ReportSummary {
    /// The self-contained page.
    pub html: PathBuf,
    /// The tables as Markdown.
    pub markdown: PathBuf,
    /// The figures for machines, as JSON.
    pub results: PathBuf,
    /// README.md's table, and the errors by steps and splits, as Markdown.
    pub summary: PathBuf,
    /// The figures' files, SVG and PNG.
    pub figures: Vec<PathBuf>,
    /// Runs that it is about.
    pub runs: Vec<String>,
    /// What was left out, a sentence each.
    pub left_out: Vec<String>,
}

/// Reads the runs in `folders` and writes the report into `out`.
///
/// # Errors
/// Bad input: a folder that holds no run, a broken file in one, or `out` cannot be written. Nothing is written before everything
/// was read and drawn.
pub fn write_report(folders: &[PathBuf], out: &Path, terminal: &Terminal) -> anyhow::Result<ReportSummary> {
    let runs = folders.iter().map(|folder| Run::read(folder)).collect::<anyhow::Result<Vec<_>>>()?;
    for (place, run) in runs.iter().enumerate() {
        let folder = run.folder.display();
        if !is_folder_name(&run.name) {
            let name = &run.name;
            return Err(bad_input(format!(
                "{folder}: the run's `name` is `{name}`, expected letters, digits, `-`, `_` and `.`: figures are named after it"
            )));
        }
        if let Some(same) = runs[..place].iter().find(|other| other.name == run.name) {
            let (other, name) = (same.folder.display(), &run.name);
            return Err(bad_input(format!(
                "{folder}: its name is `{name}`, like that of {other}, expected runs of different names"
            )));
        }
    }
    let study = Study::new(runs);
    let (results, headline) = (Results::of(study.runs.iter()), Results::of(study.headline()));
    let blocks = blocks(&study, &headline, terminal)?;
    let page = html::render(TITLE, &blocks)?;
    let text = markdown::render(TITLE, &blocks);
    let mut drawn = Vec::new();
    for block in &blocks {
        let Block::Figure(figure) = block else { continue };
        drawn.push((format!("{}.svg", figure.name), figure.picture.svg()?.into_bytes()));
        drawn.push((format!("{}.png", figure.name), figure.picture.png()?));
    }

    let folder = OutputFolder::claim(out)?;
    let figures = OutputFolder::claim(&folder.join("figures"))?;
    let (html, markdown) = (folder.join("report.html"), folder.join("report.md"));
    OutputFile::claim(&html)?.write(page.as_bytes())?;
    OutputFile::claim(&markdown)?.write(text.as_bytes())?;
    let (results_file, summary) = (folder.join("results.json"), folder.join("results.md"));
    OutputFile::claim(&results_file)?.write_json(&results)?;
    OutputFile::claim(&summary)?.write(page::markdown(&headline, &results).as_bytes())?;
    let mut files = Vec::new();
    for (name, bytes) in drawn {
        let path = figures.join(name);
        OutputFile::claim(&path)?.write(&bytes)?;
        files.push(path);
    }
    let absent = blocks.iter().filter_map(|block| match block {
        Block::Absent(sentence) => Some(sentence.clone()),
        _ => None,
    });
    Ok(ReportSummary {
        html,
        markdown,
        results: results_file,
        summary,
        figures: files,
        runs: study.runs.iter().map(|run| run.name.clone()).collect(),
        left_out: absent.collect(),
    })
}

/// The report, from top to bottom.
fn blocks(study: &Study, headline: &Results, terminal: &Terminal) -> anyhow::Result<Vec<Block>> {
    let section = |title: &str| Block::Section(title.to_owned());
    let mut blocks = texts::opening(study);
    blocks.extend(study.runs.iter().flat_map(|run| &run.missing).map(Block::absent));

    blocks.push(section("In short"));
    blocks.push(figures::overview::chart(headline)?);
    blocks.push(
        summary::table(headline)
            .or_absent("the summary: no task with a single expert was scored on the test split."),
    );

    blocks.push(section("The paper's numbers beside ours"));
    blocks.push(tables::beside_the_paper(study));
    blocks.extend(figures::over_tasks(study)?);

    blocks.push(section("Integration steps"));
    blocks.push(Block::text(texts::STEPS));
    blocks.extend(figures::over_steps(study)?);
    blocks.push(tables::paired(study));
    blocks.push(tables::samplers(study));

    blocks.push(section("Fewer demonstrations"));
    blocks.push(figures::over_demonstrations(study)?);
    blocks.push(tables::by_demonstrations(study));

    blocks.push(section("Ablations"));
    blocks.push(tables::ablations(study));

    blocks.push(section("Along the trajectory"));
    blocks.extend(figures::along_the_trajectory(study)?);

    blocks.push(section("Every score"));
    blocks.push(Block::text(texts::SCORES));
    blocks.extend(tables::scores(study));
    blocks.extend(tables::over_training_seeds(study));

    blocks.push(section("Acting in the simulator"));
    blocks.push(tables::closed_loop(study));

    blocks.push(section("The flows themselves"));
    blocks.push(Block::text(texts::FLOWS));
    blocks.extend(figures::flows(study, terminal)?);
    blocks.push(tables::straightness(study));
    blocks.push(tables::modes(study));
    blocks.push(tables::turned(study));

    blocks.push(section("Nodes"));
    blocks.extend(figures::nodes(study)?);
    blocks.push(tables::nodes(study));

    blocks.push(section("Data and training"));
    blocks.push(Block::text(texts::TRAINING));
    blocks.extend(figures::data(study)?);
    blocks.push(tables::stages(study));

    blocks.push(section("Latency"));
    blocks.extend(figures::over_time(study)?);
    blocks.push(tables::latency(study));

    blocks.push(section("Where the figures come from"));
    blocks.extend(tables::origin(study));
    Ok(blocks)
}
