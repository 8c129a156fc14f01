"""The process of one rig: its loop, what it is asked to do, and a stop that waits for no sample."""
