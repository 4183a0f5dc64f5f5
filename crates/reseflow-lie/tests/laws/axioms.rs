//! Group axioms, the action, the adjoint representations: the matrices are the oracle.

use crate::draw::{close, close_vectors, for_all};
use crate::group::{LieGroup, laws_for_every_group};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use reseflow_lie::{BodyTwist, SE3};

laws_for_every_group!(
    the_product_is_that_of_matrices,
    identity_and_inverse,
    the_product_is_associative,
    the_action_is_that_of_matrices_and_composes,
    the_adjoint_conjugates,
    the_adjoint_is_a_homomorphism,
    the_adjoint_of_an_exponential_is_the_exponential_of_ad,
    ad_is_the_commutator,
);

pub(crate) fn the_product_is_that_of_matrices<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, _| {
        let (x, y) = (a.element::<G>(), b.element::<G>());
        close(&x.times(&y).matrix(), &(x.matrix() * y.matrix()), 1e-14)
    })
}

pub(crate) fn identity_and_inverse<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let x = a.element::<G>();
        let size = x.matrix().nrows();
        close(&G::identity().matrix(), &DMatrix::identity(size, size), 0.0)?;
        close(&x.times(&G::identity()).matrix(), &x.matrix(), 1e-15)?;
        close(&G::identity().times(&x).matrix(), &x.matrix(), 1e-15)?;
        close(&x.times(&x.inverse()).matrix(), &DMatrix::identity(size, size), 1e-14)?;
        close(&x.inverse().times(&x).matrix(), &DMatrix::identity(size, size), 1e-14)
    })
}

pub(crate) fn the_product_is_associative<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, c| {
        let (x, y, z) = (a.element::<G>(), b.element::<G>(), c.element::<G>());
        close(&x.times(&y).times(&z).matrix(), &x.times(&y.times(&z)).matrix(), 1e-14)
    })
}

pub(crate) fn the_action_is_that_of_matrices_and_composes<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, c| {
        let (x, y, point) = (a.element::<G>(), b.element::<G>(), c.linear);
        let mut homogeneous = DVector::from_element(x.matrix().nrows(), 1.0);
        homogeneous.rows_mut(0, 3).copy_from(&point);
        let moved = x.matrix() * homogeneous;
        close_vectors(
            &DVector::from_column_slice(x.act(&point).as_slice()),
            &moved.rows(0, 3).into_owned(),
            1e-14,
        )?;
        close_vectors(
            &DVector::from_column_slice(x.times(&y).act(&point).as_slice()),
            &DVector::from_column_slice(x.act(&y.act(&point)).as_slice()),
            1e-14,
        )
    })
}

pub(crate) fn the_adjoint_conjugates<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, _| {
        let (x, tangent) = (a.element::<G>(), b.tangent::<G>());
        let conjugate = x.matrix() * G::hat(&tangent) * x.inverse().matrix();
        close(&G::hat(&(x.adjoint() * &tangent)), &conjugate, 1e-13)?;
        let moved = x.times(&G::exp(&tangent)).times(&x.inverse());
        close(&G::exp(&(x.adjoint() * &tangent)).matrix(), &moved.matrix(), 1e-13)
    })
}

pub(crate) fn the_adjoint_is_a_homomorphism<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, _| {
        let (x, y) = (a.element::<G>(), b.element::<G>());
        close(&x.times(&y).adjoint(), &(x.adjoint() * y.adjoint()), 1e-13)?;
        let size = x.adjoint().nrows();
        close(&(x.inverse().adjoint() * x.adjoint()), &DMatrix::identity(size, size), 1e-13)
    })
}

pub(crate) fn the_adjoint_of_an_exponential_is_the_exponential_of_ad<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let ad = G::algebra_adjoint(&a.tangent::<G>());
        close(&a.element::<G>().adjoint(), &crate::exponential::power_series(&ad, |_| 1.0), 1e-12)
    })
}

pub(crate) fn ad_is_the_commutator<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, _| {
        let (u, v) = (a.tangent::<G>(), b.tangent::<G>());
        let commutator = G::hat(&u) * G::hat(&v) - G::hat(&v) * G::hat(&u);
        close(&G::hat(&(G::algebra_adjoint(&u) * &v)), &commutator, 1e-13)
    })
}

/// A chain of 100 000 products is as good a rotation as one: the quaternion's norm does not drift.
#[test]
fn long_products_stay_on_the_group() {
    let step = SE3::exp(&BodyTwist::new(Vector3::new(0.3, -0.2, 0.5), Vector3::new(1e-3, 0.0, 0.0)));
    let end = (0..100_000).fold(SE3::identity(), |pose, _| pose * step);
    let matrix = end.rotation.matrix();
    assert!((matrix.transpose() * matrix - Matrix3::identity()).amax() < 1e-14);
}
