"""The model of the simulated rig, of the tests of commands."""

from tests.app.conftest import model as model
