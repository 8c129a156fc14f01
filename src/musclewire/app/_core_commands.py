"""The commands of the core, and the panels of ``musclewire --help``: as a reader meets them."""

from __future__ import annotations

from musclewire.manifest import Command, CommandGroup

BEGIN = "Begin here, on the simulated wire"
LOOP = "The basic loop: record, fit, move"
BENCH = "A wire on a bench"
RECORDINGS = "Recordings"
CHOOSE = "Choose, simulate and design"
STUDIES = "Studies and the paper"
ELSEWHERE = "Take it elsewhere"
# Titles of the panels, in their order; those of other packages come last.
PANELS = (BEGIN, LOOP, BENCH, RECORDINGS, CHOOSE, STUDIES, ELSEWHERE)

COMMANDS = (
    Command(
        "demo",
        "musclewire.app._rig_commands:demo",
        "The main job on the simulated rig: characterize, fit, control by resistance, report.",
        panel=BEGIN,
        answer="musclewire.app._answers:DemoAnswer",
    ),
    Command(
        "characterize",
        "musclewire.app._rig_commands:characterize",
        "Heat and cool the wire slowly (the slow sine) and record it.",
        panel=LOOP,
        answer="musclewire.app._answers:CharacterizeAnswer",
    ),
    Command(
        "fit",
        "musclewire.app._model_commands:fit",
        "Fit the self-sensing model to a slow loop; with --wire from its resistance alone.",
        panel=LOOP,
        answer="musclewire.app._answers:FitAnswer",
    ),
    Command(
        "tune",
        "musclewire.app._model_commands:tune",
        "Find a controller's gains from the slow loop, by a published rule; -o keeps them in a .json model or .toml.",
        panel=LOOP,
        answer="musclewire.app._answers:TuneAnswer",
    ),
    Command(
        "control",
        "musclewire.app._control_command:control",
        "Closed loop: move the wire by its own resistance; MAE of each step, with --runs for many seeds.",
        panel=LOOP,
        answer="musclewire.app._answers:ControlAnswers",
    ),
    Command(
        "home",
        "musclewire.app._home_command:home",
        "Sweep the wire once and write a model that holds for the wire of today; a changed load is refused.",
        panel=LOOP,
        answer="musclewire.app._answers:HomeAnswer",
    ),
    Command(
        "doctor",
        "musclewire.app._doctor_command:doctor",
        "Check wiring, noise, polarity, sense voltage and sample clock; nothing is heated.",
        panel=BENCH,
        answer="musclewire.app._answers:DoctorAnswer",
    ),
    Command(
        "pretension",
        "musclewire.app._rig_commands:pretension",
        "Sweep the pretension, compare the hysteresis gaps, name the best for the quantity.",
        panel=BENCH,
        answer="musclewire.app._answers:PretensionAnswer",
    ),
    Command(
        "train",
        "musclewire.app._rig_commands:train",
        "Cycle a new wire until its loop repeats.",
        panel=BENCH,
        answer="musclewire.app._answers:TrainAnswer",
    ),
    Command(
        "protection",
        "musclewire.app._protection_command:protection",
        "Show the protection table: monitored conditions of a heated wire and the responses; with a rig, its limits.",
        panel=BENCH,
        answer="musclewire.app._answers:ProtectionAnswer",
    ),
    Command(
        "import",
        "musclewire.app._import_command:import_recordings",
        "Read recordings of other programs and show how they were interpreted; with -o convert one, or join two.",
        panel=RECORDINGS,
        answer="musclewire.app._answers:ImportAnswer",
    ),
    Command(
        "estimate",
        "musclewire.app._model_commands:estimate",
        "Estimate strain from a recording's resistance; errors where it has a reference.",
        panel=RECORDINGS,
        answer="musclewire.app._answers:EstimateAnswer",
    ),
    Command(
        "recover",
        "musclewire.app._recover_command:recover",
        "Make plain HDF5 of the journal that a run left when it was cut off; with -o the journal stays.",
        panel=RECORDINGS,
        answer="musclewire.app._recover_command:RecoverAnswer",
    ),
    Command(
        "rules",
        "musclewire.app._model_commands:rules",
        "Show a fuzzy rule base, and its surfaces with --plot.",
        panel=STUDIES,
        answer="musclewire.app._answers:RulesAnswer",
    ),
    Command(
        "cite",
        "musclewire.app._model_commands:cite",
        "Print the references to cite; --bibtex as entries of BibTeX.",
        panel=STUDIES,
        answer="musclewire.app._model_commands:CiteAnswer",
    ),
    Command(
        "schema",
        "musclewire.app._schema_command:schema",
        "Print the JSON Schema of a kind of file, or of what a command prints with --json.",
        panel=ELSEWHERE,
        answer="musclewire.app._schema_command:SchemaAnswer",
    ),
)
# Groups that several parts share; one is listed if any command is in it.
GROUPS = (
    CommandGroup(
        "export", "Export a model with its controller, or a simulated wire.", panel=ELSEWHERE, before="schema"
    ),
)
