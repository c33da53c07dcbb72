"""The paper's results again: its settings, figures and comparison."""
