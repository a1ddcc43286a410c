"""The test of names must see what g++ lets pass, and let pass what is no twin."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import own_names

SOURCE = """namespace palpate {
namespace {

constexpr double kHalf = 0.5;

struct Row {
  double value_at(int k) const;
};

std::optional<double> number_at(const json& record, const std::string& pointer) {
  return value_at(record);
}

template <typename Value>
Value* first_of(std::vector<Value>& all,
                int count) {
  return all.data();
}

const char* kScript = R"(
namespace {
int in_a_string(int k) {
)";

}  // namespace

double known_outside(double x) {
  return twice(x);
}

}  // namespace palpate
"""


class OwnNames(unittest.TestCase):
    def test_functions_of_unnamed_namespaces_alone(self):
        self.assertEqual(own_names.own_functions(SOURCE), {"number_at", "first_of"})

    def test_what_two_have_is_named_with_its_places(self):
        other = "namespace {\n\ndouble number_at(const json& value, const char* key) {\n}\n\n}  // namespace\n"
        self.assertEqual(own_names.find_twins({"b.cpp": other, "a.cpp": SOURCE, "c.cpp": "double number_at(int);\n"}), {"number_at": ["a.cpp", "b.cpp"]})

    def test_printers_belong_to_their_types(self):
        printer = "namespace {\n\nvoid PrintTo(const %s& plan, std::ostream* out) {\n}\n\n}  // namespace\n"
        self.assertEqual(own_names.find_twins({"a.cpp": printer % "A", "b.cpp": printer % "B"}), {})


if __name__ == "__main__":
    unittest.main()
