"""Realistic distortions for each number of coefficients OpenCV knows (k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty)."""

_ALL = [0.9, -0.3, 8e-4, -6e-4, 0.02, 1.25, -0.1, 0.01, 2e-3, -4e-4, -3e-3, 5e-4, 0.02, -0.03]
LENSES = {
    0: [],
    4: [-0.28, 0.07, 2e-4, 1.8e-5],
    5: [-0.08, 0.1, 1.1e-3, -1e-3, -0.02],
    8: _ALL[:8],
    12: _ALL[:12],
    14: _ALL,
}
FEW = (0, 5, 14)  # where each count is a program of its own
# Of wide models: MYNT EYE's, Basalt's of the TUM VI camera, and one of 200 degrees.
WIDE_LENSES = {
    "equidistant": [-0.020476443, -0.007108226, 0.00218058, -0.001192386],
    "ds": [-0.2, 0.59],
    "eucm": [0.63, 1.05],
    "omni": [1.2, -0.12, 0.02, 4e-4, -3e-4],
}
