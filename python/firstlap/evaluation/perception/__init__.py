"""Evaluation of perception against ground truth."""
