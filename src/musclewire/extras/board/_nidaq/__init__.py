"""National Instruments acquisition cards, through NI's own nidaqmx package.

    configuration   the schema of rig files of kind nidaq; scales, and how a sample period is divided
    driver          the few calls of nidaqmx that a rig makes, locally or over gRPC
    guardian        the process that owns the output: it switches off after a killed or stalled host
    output          the host's end of the guardian
    device          all of it as a device

Nothing here can see the simulator, and nothing imports nidaqmx before a rig is opened.
"""
