//! Rectified flows on SE(3) trajectories: priors, paths, objectives and solvers.
