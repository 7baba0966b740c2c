# SPDX-License-Identifier: MIT
"""Progress of an explicit run, on the terminal."""


class Bar:
    """Progress bar with step, time, dt, energy drift and time left, on rank 0."""

    def __init__(self, run, wanted):
        self.run, self._bar = run, None
        if wanted and run.comm.rank == 0:
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            columns = TextColumn("step {task.fields[step]}  t = {task.fields[time]:.4g}  dt = {task.fields[dt]:.3g}")
            drift = TextColumn("drift {task.fields[drift]:+.1e}")
            self._bar = Progress(columns, BarColumn(), drift, TimeRemainingColumn())

    def __enter__(self):
        if self._bar:
            run = self.run
            self._bar.start()
            begin, end = run._plan.begin, run._plan.until
            fields = {"step": run.step, "time": run.time, "dt": run._plan.dt, "drift": 0.0}
            self._task = self._bar.add_task("", total=end - begin, **fields)
            self._start = begin
        return self

    def show(self):
        """Bring the bar up to date."""
        run = self.run
        if self._bar and run._history.last is not None:
            row = run._history.last
            drift = run._drift(run._total(row) - run._total_start, 0.0)
            self._bar.update(self._task, completed=run.time - self._start, step=run.step, time=run.time,
                             dt=run._plan.dt, drift=drift)  # fmt: skip

    def __exit__(self, *_):
        if self._bar:
            self._bar.stop()
        return False
