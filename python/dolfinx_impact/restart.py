"""Saving and restoring explicit runs."""

import numpy as np

from . import arguments, checkpoint
from .collective import guard
from .march import Plan

# Per contact: energies, then where a rigid master is and how far it has moved; the latter are the same on all ranks.
ENERGY = ("stored", "friction", "normal", "later_friction", "later_normal")


class Restart:
    """The part of ExplicitProblem that saves and restores."""

    def describe(self):
        """Material, damping and viscosity as text: what a checkpoint is compared by."""
        if self.material is None:
            material = "a residual of one's own"
        else:
            material = ", ".join(f"{tag}: {m!r}" for tag, m in self.material.parts())
        return f"{material}; {self.damping.alpha:g}, {self.damping.beta:g}; {self._viscosity}"

    def save(self, path):
        """Write a checkpoint, HDF5: all that a run needs to go on as if it had not stopped. Collective.

        It is written as PATH.part and then renamed: if anything goes wrong with it an earlier file at `path` is as it
        was. Recorders write their histories up to now after it.

        Raises:
            RuntimeError: the folder cannot be written, no space is left; on all ranks.
        """
        with guard(self.comm, "save", path=path):
            arguments.path("path", path)
        state = self._cpp.save()
        bs = self.space.dofmap.index_map_bs
        arrays = {name: state[name].reshape(-1, bs) for name in ("u", "v", "r")}
        count = self._cpp.num_saved_parts
        parts = state["parts"].reshape(count, -1, bs)
        arrays.update({f"part{k}": parts[k] for k in range(count)})
        nodal, ranks = {}, {"accounts": state["accounts"]}
        for k, contact in enumerate(self.contact):
            energies = [np.array([side.energy()[name] for name in ENERGY]) for side in contact.sides()]
            energies[0] -= sum(energies[1:])  # the first has that of both
            for j, side in enumerate(contact.sides()):
                nodal[f"contact{k}_{j}"] = (side.nodes, _pack(side.history(), bs))
                ranks[f"contact{k}_{j}"] = energies[j]
        plan, totals = self._plan, {}
        for k, contact in enumerate(self.contact):
            rows, totals[f"contact{k}"] = contact.seen()
            nodal[f"results{k}"] = (contact.nodes, rows)
        attributes = {
            **totals,
            "time": self.time, "beyond": self._beyond, "step": self.step, "safe": self._safe, "nominal": self._nominal,
            "largest": self._largest, "total_start": self._total_start,
            "plan": np.array([plan.begin, plan.until, plan.first, plan.last] if plan else [], dtype=float),
        }  # fmt: skip
        checkpoint.write(path, self, arrays, nodal, ranks, attributes)
        for recorder in self._recorders:
            recorder.flush()

    def restore(self, path):
        """Go on from a checkpoint of the same problem, written on any number of ranks. Collective.

        On as many ranks as wrote it the run goes on bit for bit (if DOLFINx numbers the mesh as it did then, which it
        does not always on three ranks and more), on others to round-off. `advance` with the time that
        the interrupted call had continues with its very steps.

        Raises:
            RuntimeError: the file cannot be read. ValueError: it is of another mesh, material, ...; on all ranks.
        """
        with guard(self.comm, "restore", path=path):
            arguments.path("path", path)
        file = checkpoint.Reader(path, self)
        count, a = self._cpp.num_saved_parts, file.attributes
        parts = [file.arrays[f"part{k}"].ravel() for k in range(count)]
        accounts = file.ranks["accounts"]
        additive = np.ones(accounts.shape[1], dtype=bool)
        additive[self._cpp.num_additive :] = False
        for k, contact in enumerate(self.contact):
            for j, side in enumerate(contact.sides()):
                name = f"contact{k}_{j}"
                rows, found = file.at(name, side.nodes)
                rows[~found] = 0.0
                side.set_history(_unpack(rows, self.space.dofmap.index_map_bs))
                side.set_energy(*file.rank(name, np.ones(len(ENERGY), dtype=bool)))
        self._cpp.restore(
            *(np.ascontiguousarray(file.arrays[name]).ravel() for name in ("u", "v", "r")),
            np.concatenate(parts) if parts else np.zeros(0),
            np.ascontiguousarray(file.rank("accounts", additive)),
        )
        self.time, self.step, self._beyond = float(a["time"]), int(a["step"]), float(a["beyond"])
        # Loads and prescribed motion of the present time: acceleration and velocity have them in.
        table = self._table(np.array([self.time, self._beyond]))
        self._cpp.run(np.zeros(0), np.ascontiguousarray(table).ravel(), table.shape[1], np.zeros(0))
        self._safe, self._nominal = float(a["safe"]), float(a["nominal"])
        self._largest, self._total_start = float(a["largest"]), float(a["total_start"])
        plan = a["plan"]
        self._plan = Plan(plan[0], plan[1], int(plan[2]), int(plan[3])) if len(plan) else None
        self._rows, self._good, self._known_start = [], None, True
        for recorder in self._recorders:
            recorder.restart()
        self._look()
        for k, contact in enumerate(self.contact):
            contact.set_seen(file.at(f"results{k}", contact.nodes)[0], a[f"contact{k}"])


def _pack(history, bs):
    """History of a contact's nodes as one table."""
    n = len(history["closed"])
    columns = [history["tangential"].reshape(n, bs), history["slip"].reshape(n, bs), history["xi"].reshape(n, 2)]
    columns += [history["closed"].astype(float)[:, None], history["facet"].astype(float)[:, None]]
    return np.hstack(columns)


def _unpack(rows, bs):
    whole = np.ascontiguousarray
    return {
        "tangential": whole(rows[:, :bs]),
        "slip": whole(rows[:, bs : 2 * bs]),
        "xi": whole(rows[:, 2 * bs : 2 * bs + 2]),
        "closed": whole(rows[:, -2].astype(np.int8)),
        "facet": whole(np.rint(rows[:, -1]).astype(np.int64)),
    }
