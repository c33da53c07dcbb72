"""How good drivers, maps and perception are, measured."""
