"""The web server of ``musclewire serve``: who may do what, what is sent to whom, and never a rig's timing."""
