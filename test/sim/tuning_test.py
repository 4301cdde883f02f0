#!/usr/bin/python3
"""docs/tuning.md has the tables that scripts/tuning_report makes, and its symptoms have their figures.

What the figures say is tried by the report itself: nothing is rendered here.
"""
import os
import re
import sys
import unittest

SOURCE = os.path.realpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), "../.."))
sys.path.insert(0, os.path.join(SOURCE, "scripts"))
from accuracy import advice  # noqa: E402


def page():
    with open(os.path.join(SOURCE, "docs/tuning.md")) as file:
        return file.read()


def rows(name):
    text = re.search(r"<!-- table %s -->\n(.*?)<!-- end of %s -->" % (name, name), page(), re.S)
    lines = text.group(1).strip().splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


class Tuning(unittest.TestCase):
    def test_every_table_has_the_rows_that_the_report_makes(self):
        for each in advice.ADVICE:
            table = rows(each.name)
            self.assertEqual(table[0][0], "`%s`" % each.case.scene, each.name)
            self.assertEqual(table[0][1:], [title for _, title in each.columns], each.name)
            labels = [", ".join("`%s`" % s for s in settings) or "as it is"
                      for settings in each.values]
            self.assertEqual([row[0] for row in table[2:]], labels, each.name)
            for row in table[2:]:
                for figure in row[1:]:
                    self.assertRegex(figure, r"^(\d+(\.\d+)?|–)$", each.name)

    def test_links_of_the_symptoms_lead_to_a_heading(self):
        headings = {re.sub(r"[^a-z0-9 -]", "", line.lstrip("# ").lower()).replace(" ", "-")
                    for line in page().splitlines() if line.startswith("#")}
        targets = re.findall(r"\]\(#([^)]+)\)", page())
        self.assertGreater(len(targets), 8)
        self.assertEqual([t for t in targets if t not in headings], [])

    def test_only_what_stands_between_the_marks_is_replaced(self):
        text = "a\n<!-- table x -->\nold\n<!-- end of x -->\nb\n"
        self.assertEqual(advice.with_tables(text, {"x": "new"}), text.replace("old", "new"))
        with self.assertRaises(ValueError):
            advice.with_tables(text, {"y": "new"})


if __name__ == "__main__":
    unittest.main()
