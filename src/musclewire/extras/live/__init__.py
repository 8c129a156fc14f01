"""A rig operated live: its process, the web server that shows it, the page, and a client for programs."""
