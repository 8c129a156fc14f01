"""Operate the simulated wire from a program while people may watch it on the page of musclewire serve.

Starts a server of its own on a free port; with one that runs already, give its address to mw.LiveClient.
"""

import subprocess
import sys
import tempfile
import time

import musclewire as mw

with tempfile.TemporaryDirectory() as folder:
    command = [sys.executable, "-m", "musclewire", "serve", "simulated", "--output", folder]
    pipe = subprocess.PIPE  # stderr says for people what the link is, and how the server has ended
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as server:
        link = server.stdout.readline().strip()
        print("watch it at", link)
        with mw.LiveClient(link) as client, client.control("the example"):
            client.command("switch_on")
            client.wait_for("ready")
            client.command("clock_speed", factor=50)  # a simulated wire need not wait for the clock
            client.command("characterize", cycles=1)
            client.wait_for("ready")
            client.command("fit")
            model = client.wait_for("ready")["model"]
            print(f"a model of {model['quantity']} from {model['lowest']:.4f} to {model['highest']:.4f}")

            client.command("clock_speed", factor=10)
            middle = 0.5 * (model["lowest"] + model["highest"])
            client.command("control", reference={"kind": "steer", "start": middle})
            for target in (middle, 1.1 * middle, 0.9 * middle):
                client.command("target", value=target)
                client.rows()
                time.sleep(3.0)  # half a minute of the wire's time
                reached = client.rows()["estimated_strain"][-1]
                print(f"target {target:.4f}, estimate {reached:.4f}")
            print("stopped by the program:", client.stop())
        server.terminate()
