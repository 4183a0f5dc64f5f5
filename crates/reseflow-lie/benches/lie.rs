//! What one call of the scalar Lie group costs: `cargo bench -p reseflow-lie`.

use divan::{Bencher, black_box};
use reseflow_lie::{BodyTwist, SE3, SO3, Vector3};

fn main() {
    divan::main();
}

fn twist() -> BodyTwist {
    BodyTwist::new(Vector3::new(0.3, -1.2, 0.7), Vector3::new(0.1, 0.2, -0.4))
}

mod so3 {
    use super::*;

    #[divan::bench]
    fn exp(bencher: Bencher) {
        let omega = twist().angular;
        bencher.bench(|| SO3::exp(black_box(&omega)));
    }

    #[divan::bench]
    fn log(bencher: Bencher) {
        let rotation = SO3::exp(&twist().angular);
        bencher.bench(|| black_box(&rotation).log());
    }

    #[divan::bench]
    fn compose(bencher: Bencher) {
        let rotation = SO3::exp(&twist().angular);
        bencher.bench(|| black_box(&rotation) * black_box(&rotation));
    }

    #[divan::bench]
    fn left_jacobian(bencher: Bencher) {
        let omega = twist().angular;
        bencher.bench(|| SO3::left_jacobian(black_box(&omega)));
    }
}

mod se3 {
    use super::*;

    #[divan::bench]
    fn exp(bencher: Bencher) {
        let twist = twist();
        bencher.bench(|| SE3::exp(black_box(&twist)));
    }

    #[divan::bench]
    fn log(bencher: Bencher) {
        let pose = SE3::exp(&twist());
        bencher.bench(|| black_box(&pose).log());
    }

    #[divan::bench]
    fn compose(bencher: Bencher) {
        let pose = SE3::exp(&twist());
        bencher.bench(|| black_box(&pose) * black_box(&pose));
    }

    #[divan::bench]
    fn left_jacobian(bencher: Bencher) {
        let twist = twist();
        bencher.bench(|| SE3::left_jacobian(black_box(&twist)));
    }

    #[divan::bench]
    fn left_jacobian_inverse(bencher: Bencher) {
        let twist = twist();
        bencher.bench(|| SE3::left_jacobian_inverse(black_box(&twist)));
    }

    #[divan::bench]
    fn interpolate_screw(bencher: Bencher) {
        let (from, to) = (SE3::identity(), SE3::exp(&twist()));
        bencher.bench(|| black_box(&from).interpolate_screw(black_box(&to), 0.3));
    }
}
