"""Projects and tag lists of other programs, turned into ``items.yaml``."""
