# SPDX-License-Identifier: MIT
"""From forms to numbers: compiled kernels, operators on a mesh, lumped mass, rigid body modes."""
