"""An exported library compiled and measured: on this machine against Python, for boards in QEMU and simavr."""
