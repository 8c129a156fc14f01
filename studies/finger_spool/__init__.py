"""What the study of the finger's spool compares: slow loops on the finger's rig, and what the paper says of them."""
