"""What programs of others already speak: Gymnasium environments and systems of python-control."""
