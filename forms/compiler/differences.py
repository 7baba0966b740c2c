# SPDX-License-Identifier: MIT
"""Kernels that read nodal values by their differences to those of the first node: linear simplices, whose gradients are
made of these. Sweeps subtract as they gather (kernels/sweep.h): the values of all nodes are more than a processor has
registers for."""

import ffcx.codegeneration.lnodes as L


def reads_differences(tree, array, begin, num_nodes, components):
    """Whether a kernel reads the values of an array at a cell's nodes as differences to the first node alone.

    Args:
        tree: LNodes tree of the kernel.
        array: name of the array.
        begin: first entry of the values, components of the first node first.
        num_nodes: number of nodes.
        components: values per node.
    """
    entries = range(begin, begin + num_nodes * components)

    def entry(node):
        """Number of the entry that is read, from `begin` on; -1: it is not known, None: another value is read."""
        if not isinstance(node, L.ArrayAccess) or node.array.name != array:
            return None
        (index,) = node.indices
        if not isinstance(index, L.LiteralInt):
            return -1
        return index.value - begin if index.value in entries else None

    def fits(node):
        if isinstance(node, (list, tuple)):
            return all(map(fits, node))
        if not isinstance(node, L.LNode):
            return True
        if entry(node) is not None:
            return False
        if isinstance(node, L.Sub):
            pair = entry(node.lhs), entry(node.rhs)
            if None not in pair:
                low, high = sorted(pair)
                return 0 <= low < components <= high and (high - low) % components == 0
        return all(map(fits, vars(node).values()))

    return fits(tree)
