"""The method with one rule off at a time."""
