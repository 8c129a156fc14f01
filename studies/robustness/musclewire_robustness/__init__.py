"""Estimators on a population of simulated wires under disturbance, controllers at tasks: ``musclewire robustness``.

A package of its own, as musclewire's users would write it: what it adds is in its manifest.
"""

from musclewire import Command, Manifest

__all__ = ["MANIFEST"]

MANIFEST = Manifest(
    name="robustness",
    commands=(
        Command(
            "robustness",
            "musclewire_robustness.command:robustness",
            "Compare estimators on a population of simulated wires under disturbance, or controllers at tasks.",
            panel="Studies and the paper",
            before="reproduce",
            answer="musclewire_robustness.answers:RobustnessAnswers",
        ),
    ),
    names={
        "Selection": "musclewire_robustness.benchmark:Selection",
        "robustness": "musclewire_robustness.benchmark:robustness",
        "task_table": "musclewire_robustness.task_table:task_table",
        "runs_of": "musclewire_robustness.store:runs_of",
        "tuning_seeds": "musclewire_robustness.population:tuning_seeds",
    },
    run_kinds={
        "robustness": "musclewire_robustness.kind:ROBUSTNESS",
        "task": "musclewire_robustness.task_runs:TASK_RUNS",
    },
)
