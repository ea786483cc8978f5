"""Robots that come and go while a session runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from graphengine import check
from graphengine.diagnostics import Findings, NodeError, UsageError, did_you_mean, listing
from graphengine.graph_run import GraphRun, make_graph_run
from graphengine.node_context import Services, SimulationClock
from graphengine.plan import Plan
from graphengine.registry import default_registry
from graphengine.spec import RobotUse
from graphengine.uses import plan_uses, robot_uses

if TYPE_CHECKING:
    from graphengine.build import Assembly


class SceneRoster:
    """The robots of a session that was built from a scene.

    Args:
        assembly: of the scene; the plans and claims of robots that come are added to it.
        services: of the session.
        clocks: of its ticks and of its physics steps, by what graphs run on.
        fault: who hears of nodes that raise.
    """

    def __init__(
        self,
        assembly: Assembly,
        services: Services,
        clocks: Mapping[str, SimulationClock],
        fault: Callable[[NodeError], None] | None,
    ) -> None:
        from graphengine.world.population import Population  # not before a scene has brought MuJoCo in

        assert assembly.loaded is not None
        self._assembly = assembly
        self._population = Population(assembly.loaded)
        self._services = services
        self._clocks = clocks
        self._fault = fault

    def add(self, name: str, use: RobotUse) -> Sequence[GraphRun]:
        """Put a robot into the scene; its graphs, set up.

        Raises:
            CheckError: with all that is wrong with it; nothing has changed then.
        """
        findings = Findings()
        self._population.add(name, use, findings)
        runs: list[GraphRun] = []
        try:
            plans = self._plans(name, findings)
            for plan in plans:
                runs.append(make_graph_run(plan, self._services, self._clocks[plan.graph.runs], self._fault))
                runs[-1].executor.setup()
        except BaseException:
            for run in runs:
                run.close()
            self._population.remove(name)
            raise
        self._assembly.plans += plans
        self._assembly.claims = list(self._services.claims)
        return runs

    def _plans(self, name: str, findings: Findings) -> list[Plan]:
        """The plans of a robot's graphs, checked beside all others."""
        assembly = self._assembly
        assert assembly.loaded is not None
        assert assembly.files is not None
        assert assembly.options is not None
        robot, stage = assembly.loaded.robots[name], assembly.world.stage
        uses = robot_uses(robot, stage, assembly.files, findings, robot_state=assembly.options.robot_state)
        plans = plan_uses(uses, assembly.files, assembly.options.registry or default_registry(), findings)
        findings.raise_errors()
        check.check_plans(plans, assembly.world, findings, prims_known=True)
        findings.raise_errors()
        return plans

    def remove(self, name: str, graphs: Sequence[GraphRun]) -> Sequence[GraphRun]:
        """Take a robot away, with its graphs and topics; which of the session's graphs those were.

        Raises:
            UsageError: there is no such robot, or a graph that is not its own reads something of it.
        """
        loaded = self._assembly.loaded
        assert loaded is not None
        if name not in loaded.robots:
            raise UsageError(
                f"no robot {name!r}\n  {did_you_mean(name, loaded.robots) or listing(loaded.robots, 'robots')}"
            )
        own = [run for run in graphs if run.name.startswith(f"{name}/")]
        for run in graphs:
            reader = None if run in own else run.contexts.bound(loaded.robots[name].prim_path)
            if reader is not None:
                raise UsageError(f"{name} cannot be removed: {reader} of graph {run.name} reads something of it")
        for run in own:
            run.close()
        gone = [run.executor.plan for run in own]
        self._assembly.plans = [plan for plan in self._assembly.plans if plan not in gone]
        self._assembly.claims = list(self._services.claims)
        self._population.remove(name)
        return own
