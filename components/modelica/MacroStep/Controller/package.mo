within MacroStep;
package Controller "Blocks of the controller socket"
end Controller;
