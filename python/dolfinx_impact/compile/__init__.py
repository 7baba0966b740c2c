# SPDX-License-Identifier: MIT
"""`dolfinx-impact compile`: kernels of a user's UFL file as a header for C++ programs."""
