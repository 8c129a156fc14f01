"""The pretensioner: a serpentine flexure between a clamped pad and the connector that wire and tendon share."""
