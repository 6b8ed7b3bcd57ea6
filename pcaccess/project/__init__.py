"""What a user writes: ``items.yaml`` and the formats it is imported from and exported to."""
