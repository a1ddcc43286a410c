// A table of compliances as a file, for other simulators and for a later run.
#pragma once

#include <filesystem>

#include "core/dynamics/reduced/compliance_table.h"

namespace palpate::reference {

/// Writes `palpate/compliance_table/1`: lines of text up to one that says "end", then numbers, little-endian
/// (docs/reduced.md has the layout).
void write_table(const std::filesystem::path& path, const dynamics::ComplianceTable& table);

/// Reads it back to the same bits. Throws: InputError with the file's name for anything else: another schema,
/// a size that does not fit, numbers that are not finite, bytes that are missing or left over.
dynamics::ComplianceTable read_table(const std::filesystem::path& path);

}  // namespace palpate::reference
