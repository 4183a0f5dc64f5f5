//! The crate's integration tests: files, windows, rollouts and logs, through the public interface only.

#[cfg(test)]
mod broken_files;
#[cfg(test)]
mod dataset_files;
#[cfg(test)]
mod episodes;
#[cfg(test)]
mod mcap_logs;
mod pair_files;
#[cfg(test)]
mod point_scene;
#[cfg(test)]
mod rollouts;
#[cfg(test)]
mod samples;
