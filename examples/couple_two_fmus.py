"""Export a wire and its controller as FMUs, and close the loop between them as any co-simulation tool would."""

import tempfile

import fmpy

import musclewire as mw

HOLD_S, LEVELS_PCT = 6.0, (1.0, 1.5, 2.0, 2.5, 2.0, 1.5, 1.0)


class Instance:
    """An FMU that FMPy has loaded, with its variables by name."""

    def __init__(self, fmu):
        folder = fmpy.extract(str(fmu.path))
        description = fmpy.read_model_description(folder)
        self.place = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.fmu = fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation")
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, name, value):
        self.fmu.setReal([self.place[name]], [value])

    def get(self, name):
        return self.fmu.getReal([self.place[name]])[0]


with mw.open_rig("simulated") as rig:
    model = mw.fit(mw.characterize(rig))
    leg_length_m = rig.leg_length_m

with tempfile.TemporaryDirectory() as folder:
    exported = mw.export_fmu("simulated", folder), mw.export_fmu(model, folder)
    wire, controller = (Instance(fmu) for fmu in exported)
    step_s, time_s = exported[0].step_s, 0.0

    print("target   strain at the end of the step")
    for level_pct in LEVELS_PCT:
        controller.set("target", level_pct / 100.0)
        for _ in range(round(HOLD_S / step_s)):
            # First the wire, then the controller with what the wire's voltages were: no algebraic loop, no delay.
            wire.set("drive_voltage_v", controller.get("drive_voltage_v"))
            wire.fmu.doStep(time_s, step_s)
            for voltage in ("wire_voltage_v", "shunt_voltage_v"):
                controller.set(voltage, wire.get(f"mean_{voltage}"))
            controller.fmu.doStep(time_s, step_s)
            time_s += step_s
        strain_pct = 100.0 * wire.get("displacement_m") / leg_length_m
        print(f"{level_pct:.1f} %    {strain_pct:.3f} %")

    for instance in (wire, controller):
        instance.fmu.terminate()
        instance.fmu.freeInstance()
