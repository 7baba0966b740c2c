# SPDX-License-Identifier: MIT
"""Active sets that go to and fro: how their changes end, and what is told of iterations that do not converge."""

import numpy as np

NOBODY = -2  # number of no node
VIOLATION = 1e-11  # of the conditions of contact that may be left, in sizes of the bodies
PATIENCE = 3  # changes of many nodes at once that may fail to bring the active set nearer to its end


class ActiveSetIteration:
    """Keeps the changes of an active set from going round for ever.

    All nodes change at once while that brings the number of wrong ones down; if it fails to several times running, one
    node changes at a time, that with the largest number, until there are fewer wrong ones than ever before: finite for
    P-matrices. Judice and Pires (1994), Murty (1974).
    """

    def __init__(self):
        self.count, self.best, self.patience = 0, np.inf, PATIENCE

    def change(self, contacts):
        """Let the contacts change states; returns how many nodes were wrong, on all ranks. Collective."""
        single = self.patience == 0
        found = sum([c.update_active_set(False, NOBODY if single else None) for c in contacts])
        self.count += 1
        if found < self.best:
            self.best, self.patience = found, PATIENCE
        elif not single:
            self.patience -= 1
        if single and found:
            contact = next((c for c in contacts if c.last_change >= 0), contacts[0])
            contact.update_active_set(False, None if self.patience else contact.last_change)
        return found


def did_not_converge(result, newton, moved, small, pending, violation):
    """The Increment with what did not converge, and what to do. Collective.

    Args:
        moved: prescribed values are reached. small: so is the tolerance of the residual. pending: points whose contact
        state changes. violation: of the conditions, as contacts give it, in sizes of the bodies.
    """
    contacts, norms = newton.problem.contact, result.residual_norms
    period = result.cycle()
    found = []
    if not small:
        found.append(f"the residual is {norms[-1]:.3e}")
    if pending:
        found.append(f"{pending} contact points change their state")
    if violation >= VIOLATION:
        found += [text for text in [c.largest_violation() for c in contacts] if text]
    if not moved:
        found.append("prescribed values are not reached")
    if period:
        found.append(f"the same states come again after {period} iterations")
    text = (
        f"Newton's method did not converge in {newton.max_iterations} iterations: {', '.join(found)}; residual norms: "
        f"{', '.join(f'{n:.3e}' for n in norms)}"
    )
    if small and moved and not pending:
        # Everything rests, but a condition is not fulfilled: no load is small enough for that.
        return result.failed(text, hopeless=True)
    coarse = [text for text in [c.coarse_slave() for c in contacts] if text]
    advice = f"{'; '.join(coarse)}. {result.advice}" if coarse else None
    return result.failed(text, advice=advice)
