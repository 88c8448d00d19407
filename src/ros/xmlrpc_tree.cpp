#include "xmlrpc_tree.h"

#include <ctime>
#include <string>

namespace mass_spring {

namespace {

std::string dateText(const std::tm& date) {
  char text[32];
  const std::size_t length = std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M:%S", &date);
  return {text, length};
}

}  // namespace

Tree toTree(const XmlRpc::XmlRpcValue& value) {
  using Value = XmlRpc::XmlRpcValue;
  switch (value.getType()) {
    case Value::TypeBoolean:
      return {static_cast<const bool&>(value)};
    case Value::TypeInt:
      return {std::int64_t{static_cast<const int&>(value)}};
    case Value::TypeDouble:
      return {static_cast<const double&>(value)};
    case Value::TypeString:
      return {static_cast<const std::string&>(value)};
    case Value::TypeDateTime:
      return {dateText(static_cast<const std::tm&>(value))};
    case Value::TypeBase64: {
      const auto& bytes = static_cast<const Value::BinaryData&>(value);
      return {std::string(bytes.begin(), bytes.end())};
    }
    case Value::TypeArray: {
      Tree::List list;
      list.reserve(value.size());
      for (int i = 0; i < value.size(); ++i) list.push_back(toTree(value[i]));
      return {std::move(list)};
    }
    case Value::TypeStruct: {
      Tree::Map map;
      for (const auto& [key, member] : value) map.emplace(key, toTree(member));
      return {std::move(map)};
    }
    case Value::TypeInvalid:
      break;
  }
  return {};
}

}  // namespace mass_spring
