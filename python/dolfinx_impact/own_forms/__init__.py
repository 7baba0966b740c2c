# SPDX-License-Identifier: MIT
"""Forms of a user: what is said about them, the files they are written in, small meshes that they are tried on."""
