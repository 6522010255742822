"""Formulas are written as GitHub draws them, and a renderer takes them all."""
import os
import sys

import pytest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(TOP, 'doc'))

import formulas  # noqa: E402


def test_formulas_are_written_as_github_draws_them():
    for path in formulas.documents():
        text = formulas.read(path)
        assert formulas.fixed(text) == text, f'{path}: doc/formulas.py --fix'


def test_formulas_pass_a_renderer():
    pytest.importorskip('latex2mathml')
    found = [formula for path in formulas.documents()
             for formula in formulas.formulas(formulas.read(path))]
    assert len(found) > 300
    assert [fault for fault in map(formulas.fault, found) if fault] == []


def test_the_checks_of_formulas_can_fail():
    assert formulas.fixed(r'the gap $g\,e$ and `cost $5`') == r'the gap $`g\,e`$ and `cost $5`'
    assert formulas.fixed('$$ a $$\n') == '```math\na\n```\n'
    pytest.importorskip('latex2mathml')
    assert formulas.fault(r'\nosuchthing{x}') and formulas.fault(r'\frac{1')
