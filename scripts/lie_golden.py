#!/usr/bin/env python3
"""Golden values for crates/reseflow-lie: writes crates/reseflow-lie/tests/golden/lie.json.

    pip install scipy mpmath && python3 scripts/lie_golden.py

- `exp`: rotation vectors and twists with scipy.linalg.expm of their hat matrices, and the left Jacobian as the
  upper right block of expm([[ad, I], [0, 0]]) = [[.., integral of exp(s ad)], [0, I]].
- `log`: poses with scipy.linalg.logm of their matrices.
- `precise`: the same as `exp` and `log` at once, near the identity and near a half turn, from mpmath with 60 digits.
- `quaternion`: scipy's Rotation as x, y, z, w.
- `coefficients`: the scalar functions of src/coefficients.rs, from mpmath with 60 digits.

Matrices are row-major. Every number is the double nearest to the value computed.
"""

import json
from pathlib import Path

import mpmath
import numpy
import scipy.linalg
from scipy.spatial.transform import Rotation

OUTPUT = Path(__file__).resolve().parent.parent / "crates/reseflow-lie/tests/golden/lie.json"
SEED = 3407

mpmath.mp.dps = 60


def cross_matrix(v):
    x, y, z = v
    return numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)


def hat(twist):
    matrix = numpy.zeros((4, 4), dtype=object)
    matrix[:3, :3] = cross_matrix(twist[:3])
    matrix[:3, 3] = twist[3:]
    return matrix


def algebra_adjoint(twist):
    matrix = numpy.zeros((6, 6), dtype=object)
    matrix[:3, :3] = matrix[3:, 3:] = cross_matrix(twist[:3])
    matrix[3:, :3] = cross_matrix(twist[3:])
    return matrix


def flat(matrix):
    return [float(entry) for entry in numpy.asarray(matrix).ravel()]


def unit(rng):
    vector = rng.normal(size=3)
    return vector / numpy.linalg.norm(vector)


def exp_entry(twist):
    augmented = numpy.zeros((12, 12))
    augmented[:6, :6] = algebra_adjoint(twist)
    augmented[:6, 6:] = numpy.eye(6)
    return {
        "twist": flat(twist),
        "matrix": flat(scipy.linalg.expm(hat(twist).astype(float))),
        "left_jacobian": flat(scipy.linalg.expm(augmented)[:6, 6:]),
    }


def log_entry(twist):
    matrix = scipy.linalg.expm(hat(twist).astype(float))
    logarithm = scipy.linalg.logm(matrix).real
    angular = [logarithm[2, 1], logarithm[0, 2], logarithm[1, 0]]
    return {"matrix": flat(matrix), "twist": flat(numpy.concatenate([angular, logarithm[:3, 3]]))}


def precise_entry(twist):
    matrix = mpmath.expm(mpmath.matrix(hat([mpmath.mpf(float(entry)) for entry in twist]).tolist()), method="taylor")
    return {"twist": flat(twist), "matrix": [float(matrix[i, j]) for i in range(4) for j in range(4)]}


def coefficients_entry(theta):
    t = mpmath.mpf(theta)
    half = t / 2
    return {
        "theta": theta,
        "one_minus_cos_over_square": float((1 - mpmath.cos(t)) / t**2),
        "theta_minus_sin_over_cube": float((t - mpmath.sin(t)) / t**3),
        "second_order_coupling": float((t**2 + 2 * mpmath.cos(t) - 2) / (2 * t**4)),
        "third_order_coupling": float((2 * t - 3 * mpmath.sin(t) + t * mpmath.cos(t)) / (2 * t**5)),
        "inverse_jacobian_square": float((1 - half * mpmath.cot(half)) / t**2),
    }


def main():
    rng = numpy.random.default_rng(SEED)
    angles = [0.0, 1e-8, 1e-4, 0.01, 0.3, 1.0, 1.5, 2.0, 2.5, 3.0, 3.1, 3.5, 5.0]
    twists = [numpy.concatenate([unit(rng) * angle, rng.normal(size=3)]) for angle in angles for _ in range(2)]
    principal = [numpy.concatenate([unit(rng) * angle, rng.normal(size=3)]) for angle in angles[3:11] for _ in range(2)]
    hard_angles = [1e-300, 1e-12, 1e-8, 1e-5, 1e-3, 3.14, numpy.pi - 1e-4, numpy.pi - 1e-6]
    hard = [numpy.concatenate([unit(rng) * angle, rng.normal(size=3)]) for angle in hard_angles for _ in range(2)]
    rotations = [unit(rng) * angle for angle in angles[4:11]]
    thetas = [float(theta) for theta in numpy.concatenate([10.0 ** numpy.arange(-8, 0), numpy.arange(1, 13) * 0.5])]
    golden = {
        "generator": f"scripts/lie_golden.py, seed {SEED}",
        "exp": [exp_entry(twist) for twist in twists],
        "log": [log_entry(twist) for twist in principal],
        "precise": [precise_entry(twist) for twist in hard],
        "quaternion": [
            {"omega": flat(omega), "xyzw": flat(Rotation.from_rotvec(omega).as_quat(canonical=True))}
            for omega in rotations
        ],
        "coefficients": [coefficients_entry(theta) for theta in thetas + [float(numpy.pi), 3.141592, 3.1416]],
    }
    OUTPUT.parent.mkdir(parents=True, exist_ok=True)
    lines = []
    for key, value in golden.items():
        if isinstance(value, list):
            body = ",\n    ".join(json.dumps(entry) for entry in value)
            lines.append(f"  {json.dumps(key)}: [\n    {body}\n  ]")
        else:
            lines.append(f"  {json.dumps(key)}: {json.dumps(value)}")
    OUTPUT.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
