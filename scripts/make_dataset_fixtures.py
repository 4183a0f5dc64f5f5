#!/usr/bin/env python3
"""Writes the data-set fixtures of crates/reseflow-data/tests with NumPy alone, so that the reader is tested against
files that our own writer never touched. Needs: pip install numpy. Run from the repository's root."""

import json
from pathlib import Path

import numpy as np

FOLDER = Path("crates/reseflow-data/tests/fixtures")
E, T, N = 2, 3, 4


def arrays():
    """The values are formulas of the indices, which the tests repeat."""
    e, t, n, c = np.meshgrid(np.arange(E), np.arange(T), np.arange(N), np.arange(3), indexing="ij")
    frame = np.arange(E * T, dtype=np.float64).reshape(E, T)

    def poses(angle, x):
        pose = np.zeros((E, T, 4, 4))
        pose[..., 0, 0] = pose[..., 1, 1] = np.cos(angle)
        pose[..., 1, 0] = np.sin(angle)
        pose[..., 0, 1] = -np.sin(angle)
        pose[..., 2, 2] = pose[..., 3, 3] = 1.0
        pose[..., 0, 3], pose[..., 1, 3], pose[..., 2, 3] = x, -0.5, 2.0 * x
        return pose.astype(np.float32)

    return {
        "points": (e + t / 8 + n / 64 + c / 512).astype(np.float32),
        "rgb": (100 * e + 30 * t + 5 * n + c).astype(np.uint8),
        "gripper_pose": poses(0.3 * frame, 0.25 * frame),
        "gripper_opening": (frame / 8).astype(np.float32),
        "action_pose": poses(0.3 * (frame + 1), 0.25 * (frame + 1)),
        "action_opening": ((frame + 1) / 8).astype(np.float32),
    }


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    plain = arrays()
    meta = {"task": "door", "version": 1, "robot": {"arm": 7}, "note": "Öffnung → 1"}
    np.savez(FOLDER / "savez.npz", **plain, meta=np.array(json.dumps(meta, ensure_ascii=False)))
    np.savez_compressed(FOLDER / "savez_compressed.npz", **plain)
    odd = {name: np.asfortranarray(array) for name, array in plain.items()}
    odd["points"] = odd["points"].astype(">f4")
    np.savez(FOLDER / "fortran_big_endian.npz", **odd, meta=np.array({"pickled": True}, dtype=object))


if __name__ == "__main__":
    main()
