#!/usr/bin/env python3
"""Golden values for crates/reseflow-net: writes irreps.json and convolution.json of crates/reseflow-net/tests/golden.

    pip install e3nn-jax && python3 scripts/irreps_golden.py

- `irreps.json`: real spherical harmonics of degrees 0 to 6 (normalisation "component"), Wigner matrices of degrees 0 to 4, and
  real Clebsch-Gordan coefficients (sum of squares 1) as their non-zero entries, all in e3nn's basis.
- `convolution.json`: e3nn's fully connected tensor product of features with the spherical harmonics of an edge. Weights are
  listed by (degree in, degree of the harmonic, degree out), each [channels in, channels out], with unit path weight, so that a
  path is weight * coefficient * feature * harmonic. Features are [2l + 1, channels] by degree.

e3nn counts parities; here every degree is declared even, so that all paths exist, as for SO(3) alone. Arrays are row-major.
Every number is the double that e3nn computes, to 15 digits.
"""

import json
from pathlib import Path

import jax

jax.config.update("jax_enable_x64", True)

import e3nn_jax as e3nn  # noqa: E402
import numpy  # noqa: E402
from e3nn_jax.legacy import FunctionalFullyConnectedTensorProduct  # noqa: E402
from scipy.spatial.transform import Rotation  # noqa: E402

OUTPUT = Path(__file__).resolve().parent.parent / "crates/reseflow-net/tests/golden"
SEED = 3407


def flat(array):
    return [float(f"{value:.15g}") + 0.0 for value in numpy.asarray(array, dtype=numpy.float64).ravel()]


def harmonics(degree, direction):
    irreps = e3nn.Irreps([(1, (degree, (-1) ** degree))])
    return e3nn.spherical_harmonics(irreps, numpy.asarray(direction), True, normalization="component").array


def harmonics_entry(direction):
    values = numpy.concatenate([harmonics(degree, direction) for degree in range(7)])
    return {"direction": flat(direction), "values": flat(values)}


def wigner_entry(rotation):
    matrix = rotation.as_matrix()
    blocks = [flat(e3nn.Irrep(degree, 1).D_from_matrix(matrix)) for degree in range(5)]
    return {"rotation": flat(matrix), "blocks": blocks}


def clebsch_gordan_entry(degrees):
    array = numpy.asarray(e3nn.clebsch_gordan(*degrees))
    entries = {
        str(index): float(f"{value:.15g}") for index, value in enumerate(array.ravel()) if abs(value) > 1e-12
    }
    return {"degrees": degrees, "entries": entries}


def triples():
    for first in range(5):
        for second in range(5):
            for third in range(abs(first - second), min(first + second, 4) + 1):
                yield [first, second, third]


def convolution_entry(max_in, channels_in, max_out, channels_out, rng):
    direction = rng.normal(size=3)
    irreps_in = e3nn.Irreps([(channels_in, (degree, 1)) for degree in range(max_in + 1)])
    irreps_out = e3nn.Irreps([(channels_out, (degree, 1)) for degree in range(max_out + 1)])
    irreps_edge = e3nn.Irreps([(1, (degree, 1)) for degree in range(max_in + max_out + 1)])
    product = FunctionalFullyConnectedTensorProduct(
        irreps_in,
        irreps_edge,
        irreps_out,
        irrep_normalization="none",
        path_normalization="element",
        gradient_normalization="element",
    )
    assert all(instruction.path_weight == 1.0 for instruction in product.instructions)
    weights = [rng.normal(size=(channels_in, 1, channels_out)) for _ in product.instructions]
    # e3nn lays features out as [channels, 2l + 1].
    features = [rng.normal(size=(channels_in, 2 * degree + 1)) for degree in range(max_in + 1)]
    edge = numpy.concatenate([harmonics(degree, direction) for degree in range(max_in + max_out + 1)])
    output = product.left_right(
        weights,
        e3nn.IrrepsArray(irreps_in, numpy.concatenate([feature.ravel() for feature in features])),
        e3nn.IrrepsArray(irreps_edge, edge),
    )
    return {
        "sizes": [max_in, channels_in, max_out, channels_out],
        "direction": flat(direction),
        "weights": [
            {"path": [instruction.i_in1, instruction.i_in2, instruction.i_out], "values": flat(weight)}
            for instruction, weight in zip(product.instructions, weights)
        ],
        "features": [flat(feature.T) for feature in features],
        "output": [flat(numpy.asarray(chunk).T) for chunk in output.chunks],
    }


def write(name, content):
    OUTPUT.mkdir(parents=True, exist_ok=True)
    (OUTPUT / name).write_text(json.dumps(content, separators=(",", ":")).replace("},{", "},\n{") + "\n")


def main():
    rng = numpy.random.default_rng(SEED)
    directions = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], *rng.normal(size=(6, 3))]
    directions = [numpy.asarray(direction, dtype=float) for direction in directions]
    directions = [direction / numpy.linalg.norm(direction) for direction in directions]
    rotations = [Rotation.from_quat(quaternion) for quaternion in rng.normal(size=(4, 4))]
    rotations.append(Rotation.from_rotvec([0.0, 0.3, 0.0]))
    write(
        "irreps.json",
        {
            "spherical_harmonics": [harmonics_entry(direction) for direction in directions],
            "wigner": [wigner_entry(rotation) for rotation in rotations],
            "clebsch_gordan": [clebsch_gordan_entry(degrees) for degrees in triples()],
        },
    )
    sizes = [(3, 2, 3, 2), (1, 3, 2, 2), (2, 1, 0, 3), (0, 4, 3, 1)]
    write("convolution.json", [convolution_entry(*size, rng) for size in sizes])


if __name__ == "__main__":
    main()
